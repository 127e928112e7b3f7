// Where the payloads of keyframes live: in memory up to a bound, the rest in a temporary file.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tvl/map/keyframe.h"

namespace tvl {

struct KeyframeStoreOptions {
  // Payloads kept in memory. A keyframe of a 64-beam lidar takes 0.25-0.35 MB (points 16 bytes
  // each, 500 image features 60 bytes each): 1.5-2 km of road without touching the file.
  double memory_mib = 512.0;
  // Of the file for the others, made when first needed and gone with the store. Empty: the
  // system's folder for temporary files.
  std::string folder;
  void Check() const;
};

// Returns what was put in, bit by bit. The least recently used payloads leave memory first; each is
// written once. Where the file cannot be made or written, what is not in it by then stays in
// memory, and fault() says why. Thread-safe.
class KeyframeStore {
 public:
  explicit KeyframeStore(const KeyframeStoreOptions& options);
  ~KeyframeStore();
  KeyframeStore(const KeyframeStore&) = delete;
  KeyframeStore& operator=(const KeyframeStore&) = delete;

  // Adds, or replaces what has that index.
  void Put(int index, std::shared_ptr<const KeyframePayload> payload);
  // Throws Error for an index that was never put, InputError if the file cannot be read back.
  std::shared_ptr<const KeyframePayload> Get(int index) const;
  // Parts of it, kept alive as a whole.
  std::shared_ptr<const KeyframeCloud> Cloud(int index) const;
  std::shared_ptr<const ImageFeatures> Image(int index) const;

  size_t memory_bytes() const;  // of the payloads held in memory
  size_t file_bytes() const;
  std::string fault() const;  // empty: none

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// What a payload takes in memory and, to a few bytes, in the file.
size_t SizeOf(const KeyframePayload& payload);

}  // namespace tvl
