// Compressed chunks of bags: bzip2, LZ4 frames (lz4 frame format specification) and Zstandard
// (RFC 8878).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tvl/io/ros/byte_source.h"

namespace tvl {

enum class Compression : uint8_t { kNone, kBz2, kLz4, kZstd };

// "" and "none", "bz2", "lz4", "zstd", as bags call them. Throws InputError beginning with `source`
// for any other.
Compression CompressionByName(const std::string& name, const std::string& source);
const char* ToString(Compression compression);

struct Inflated {
  std::vector<uint8_t> bytes;  // what could be inflated, at most what was asked for
  std::string error;           // why it is less than that; empty if it is not
};

// Inflates the first `most_bytes` bytes of what is stored at [offset, offset + stored_bytes) of
// `source`, reading no more of it than that takes. Memory grows with what is really inflated, never
// with what a header announces. Damaged data ends the bytes and is told in `error`.
Inflated Inflate(const ByteSource& source, uint64_t offset, uint64_t stored_bytes,
                 Compression compression, uint64_t most_bytes);

}  // namespace tvl
