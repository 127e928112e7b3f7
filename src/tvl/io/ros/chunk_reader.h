// Bytes of the chunks of a bag, inflated on demand.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tvl/io/ros/byte_source.h"
#include "tvl/io/ros/compression.h"
#include "tvl/io/ros/message_store.h"

namespace tvl {

struct Chunk {
  uint64_t offset = 0;          // of the stored bytes in the file
  uint64_t stored_bytes = 0;    // compressed
  uint64_t inflated_bytes = 0;  // as the file says
  Compression compression = Compression::kNone;
};

// Reading is const and safe to call from several threads; Add is not. Keeps the few chunks that
// were used last. Chunks that are not compressed are read from the file message by message.
class ChunkReader {
 public:
  explicit ChunkReader(std::shared_ptr<const ByteSource> source) : source_(std::move(source)) {}

  // Returns the number of the chunk. Throws InputError for chunks outside the file and for those
  // that would be larger than kMostMessageBytes once inflated; a chunk that is not compressed may
  // have any size.
  uint32_t Add(const Chunk& chunk);
  void Clear() { chunks_.clear(), cache_.clear(); }
  const Chunk& chunk(uint32_t number) const { return chunks_[number]; }
  size_t size() const { return chunks_.size(); }
  const ByteSource& source() const { return *source_; }

  // Up to `most_bytes` from `offset` of the chunk on: fewer where the chunk ends or is damaged.
  // `start_only`: no more of the chunk is inflated than that.
  MessageBytes ReadUpTo(uint32_t number, uint64_t offset, uint64_t most_bytes,
                        bool start_only) const;
  // Exactly `bytes` of them. Throws InputError with the place and what is wrong.
  MessageBytes Read(uint32_t number, uint64_t offset, uint64_t bytes) const;
  // File, offset of the chunk and offset in it, for messages.
  std::string Place(uint32_t number, uint64_t offset) const;
  // Kinds of compression that occur from chunk `first` on, for people: "lz4", "none, zstd".
  std::string CompressionNames(size_t first = 0) const;

 private:
  struct Entry {
    uint32_t number = 0;
    bool complete = false;  // or only a start of the chunk
    std::shared_ptr<const std::vector<uint8_t>> bytes;
    std::string error;
  };
  Entry Inflated(uint32_t number, uint64_t needed_bytes, bool start_only) const;

  std::shared_ptr<const ByteSource> source_;
  std::vector<Chunk> chunks_;
  mutable std::mutex mutex_;
  mutable std::vector<Entry> cache_;  // used last at the end
};

}  // namespace tvl
