// For the fuzz targets of bag formats.
#pragma once

#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/ros/message_store.h"

namespace tvl {

// Indexes everything and reads the start and the whole of the messages, of which a small file may
// name many in a chunk: of each topic no more than there is time for.
inline void ReadStore(const MessageStore& store) {
  constexpr size_t kMostMessages = 32;
  std::vector<size_t> all(store.topics().size());
  for (size_t k = 0; k < all.size(); ++k) all[k] = k;
  const MessageIndex index = store.Index(all);
  for (const std::vector<MessageLocation>& messages : index.topics) {
    for (size_t k = 0; k < messages.size() && k < kMostMessages; ++k) {
      try {
        store.ReadStart(messages[k], 16);
        store.Read(messages[k]);
      } catch (const InputError&) {
        continue;
      }
    }
  }
}

}  // namespace tvl
