#include "tvl/io/ros/chunk_reader.h"

#include <algorithm>
#include <array>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Messages of one instant, scan and image, lie in one chunk or in neighbouring ones: two a thread,
// for the few threads that read.
constexpr size_t kMostCachedChunks = 8;
// All cached chunks together; recorders make chunks of 1 to 4 MiB, so that this is rarely reached.
constexpr size_t kMostCachedBytes = size_t{1} << 25;

}  // namespace

uint32_t ChunkReader::Add(const Chunk& chunk) {
  TVL_CHECK_INPUT(chunk.offset <= source_->size() &&
                  chunk.stored_bytes <= source_->size() - chunk.offset)
      << source_->name() << ": byte " << chunk.offset << ": chunk of " << chunk.stored_bytes
      << " bytes reaches beyond the end of the file";
  TVL_CHECK_INPUT(chunk.compression == Compression::kNone ||
                  chunk.inflated_bytes <= kMostMessageBytes)
      << source_->name() << ": byte " << chunk.offset << ": chunk of " << chunk.inflated_bytes
      << " bytes is larger than any that is read (" << kMostMessageBytes << ")";
  TVL_CHECK_INPUT(chunks_.size() < UINT32_MAX) << source_->name() << ": too many chunks";
  chunks_.push_back(chunk);
  if (chunk.compression == Compression::kNone) chunks_.back().inflated_bytes = chunk.stored_bytes;
  return static_cast<uint32_t>(chunks_.size() - 1);
}

ChunkReader::Entry ChunkReader::Inflated(uint32_t number, uint64_t needed_bytes,
                                         bool start_only) const {
  const auto is_it = [number](const Entry& entry) { return entry.number == number; };
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = std::find_if(cache_.begin(), cache_.end(), is_it);
    if (found != cache_.end() && (found->complete || found->bytes->size() >= needed_bytes)) {
      std::rotate(found, found + 1, cache_.end());
      return cache_.back();
    }
  }
  const Chunk& chunk = chunks_[number];
  const uint64_t wanted =
      start_only ? std::min(needed_bytes, chunk.inflated_bytes) : chunk.inflated_bytes;
  tvl::Inflated inflated =
      Inflate(*source_, chunk.offset, chunk.stored_bytes, chunk.compression, wanted);
  const bool complete = wanted == chunk.inflated_bytes || !inflated.error.empty();
  Entry entry{number, complete,
              std::make_shared<const std::vector<uint8_t>>(std::move(inflated.bytes)),
              std::move(inflated.error)};
  const std::lock_guard<std::mutex> lock(mutex_);
  cache_.erase(std::remove_if(cache_.begin(), cache_.end(), is_it), cache_.end());
  cache_.push_back(entry);
  size_t bytes = 0, kept = 0;
  for (auto it = cache_.rbegin(); it != cache_.rend(); ++it) {
    bytes += it->bytes->size();
    if (kept == kMostCachedChunks || (kept > 0 && bytes > kMostCachedBytes)) break;
    ++kept;
  }
  cache_.erase(cache_.begin(), cache_.end() - static_cast<std::ptrdiff_t>(kept));
  return entry;
}

MessageBytes ChunkReader::ReadUpTo(uint32_t number, uint64_t offset, uint64_t most_bytes,
                                   bool start_only) const {
  TVL_CHECK(number < chunks_.size()) << "chunk " << number;
  const Chunk& chunk = chunks_[number];
  const uint64_t there = chunk.inflated_bytes - std::min(offset, chunk.inflated_bytes);
  const uint64_t bytes = std::min(most_bytes, there);
  if (bytes == 0) return {};
  if (chunk.compression == Compression::kNone) {
    auto read =
        std::make_shared<const std::vector<uint8_t>>(source_->Read(chunk.offset + offset, bytes));
    return {read, read->data(), read->size()};
  }
  const Entry entry = Inflated(number, offset + bytes, start_only);
  const std::vector<uint8_t>& inflated = *entry.bytes;
  if (offset >= inflated.size()) return {};
  return {entry.bytes, inflated.data() + offset,
          std::min<size_t>(bytes, inflated.size() - static_cast<size_t>(offset))};
}

MessageBytes ChunkReader::Read(uint32_t number, uint64_t offset, uint64_t bytes) const {
  TVL_CHECK_INPUT(bytes <= kMostMessageBytes)
      << Place(number, offset) << ": " << bytes << " bytes are more than any message has";
  MessageBytes read = ReadUpTo(number, offset, bytes, false);
  if (read.size == bytes) return read;
  const bool compressed = chunk(number).compression != Compression::kNone;
  const std::string error = compressed ? Inflated(number, 0, true).error : std::string();
  throw InputError(Place(number, offset) + ": " + std::to_string(bytes) +
                   " bytes are announced, there are " + std::to_string(read.size) +
                   (error.empty() ? "" : " (" + error + ")"));
}

std::string ChunkReader::Place(uint32_t number, uint64_t offset) const {
  return source_->name() + ": byte " + std::to_string(offset) + " of the chunk at byte " +
         std::to_string(chunk(number).offset);
}

std::string ChunkReader::CompressionNames(size_t first) const {
  std::array<bool, 4> used{};
  for (size_t k = first; k < chunks_.size(); ++k) {
    used.at(static_cast<size_t>(chunks_[k].compression)) = true;
  }
  std::string names;
  for (size_t k = 0; k < used.size(); ++k) {
    if (!used[k]) continue;
    names += (names.empty() ? "" : ", ") + std::string(ToString(static_cast<Compression>(k)));
  }
  return names.empty() ? "none" : names;
}

}  // namespace tvl
