// Bytes at offsets: a file that is read piece by piece, or memory (tests and fuzzing).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace tvl {

// Const and safe to call from several threads.
class ByteSource {
 public:
  explicit ByteSource(std::string name) : name_(std::move(name)) {}
  virtual ~ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  const std::string& name() const { return name_; }  // the file, for messages
  virtual uint64_t size() const = 0;
  // Copies `bytes` bytes from `offset` on to `to`. Throws InputError with the name and the offset
  // where they are not all there.
  void Read(uint64_t offset, size_t bytes, uint8_t* to) const;
  // The same as a vector. Nothing is allocated before it is known that the bytes exist.
  std::vector<uint8_t> Read(uint64_t offset, uint64_t bytes) const;

 private:
  void CheckInside(uint64_t offset, uint64_t bytes) const;
  // The range is inside. Returns false where reading fails all the same.
  virtual bool ReadInside(uint64_t offset, size_t bytes, uint8_t* to) const = 0;

  std::string name_;
};

// Throws InputError if the file cannot be opened.
std::unique_ptr<ByteSource> OpenFileSource(const std::string& path);

// Does not copy: the memory must outlive the source.
std::unique_ptr<ByteSource> MemorySource(const std::string& name, const uint8_t* data,
                                         uint64_t bytes);

// Walks through the bytes [begin, end) of a source, reading ahead by `window_bytes` at a time so
// that small records do not cost a system call each. For one thread.
class SourceCursor {
 public:
  // An `end` beyond the source is taken as its end, a `begin` beyond `end` as `end`.
  SourceCursor(const ByteSource& source, uint64_t begin, uint64_t end, size_t window_bytes);

  uint64_t position() const { return position_; }
  uint64_t remaining() const { return end_ - position_; }
  const ByteSource& source() const { return source_; }
  // The next bytes, without moving; valid until the next call. Throws InputError with the offset
  // where so many are not left.
  const uint8_t* Peek(size_t bytes);
  // As Peek, and moves behind them.
  const uint8_t* Take(size_t bytes);
  // Moves on. Throws InputError like Peek.
  void Skip(uint64_t bytes);

 private:
  void CheckLeft(uint64_t bytes) const;

  const ByteSource& source_;
  uint64_t position_, end_;
  size_t window_bytes_;
  std::vector<uint8_t> window_;  // bytes from window_begin_ on
  uint64_t window_begin_ = 0;
};

}  // namespace tvl
