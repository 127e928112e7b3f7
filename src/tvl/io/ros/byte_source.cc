#include "tvl/io/ros/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "tvl/base/check.h"

namespace tvl {
namespace {

class FileSource : public ByteSource {
 public:
  explicit FileSource(const std::string& path)
      : ByteSource(path), descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    TVL_CHECK_INPUT(descriptor_ >= 0) << path << ": cannot be opened: " << std::strerror(errno);
    struct stat status = {};
    if (fstat(descriptor_, &status) != 0 || !S_ISREG(status.st_mode)) {
      close(descriptor_);
      throw InputError(path + ": not a regular file");
    }
    size_ = static_cast<uint64_t>(status.st_size);
  }
  ~FileSource() override { close(descriptor_); }

  uint64_t size() const override { return size_; }

 private:
  bool ReadInside(uint64_t offset, size_t bytes, uint8_t* to) const override {
    while (bytes > 0) {
      const ssize_t got = pread(descriptor_, to, bytes, static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      to += got, offset += static_cast<uint64_t>(got), bytes -= static_cast<size_t>(got);
    }
    return true;
  }

  int descriptor_;
  uint64_t size_ = 0;
};

class Memory : public ByteSource {
 public:
  Memory(const std::string& name, const uint8_t* data, uint64_t bytes)
      : ByteSource(name), data_(data), bytes_(bytes) {}
  uint64_t size() const override { return bytes_; }

 private:
  bool ReadInside(uint64_t offset, size_t bytes, uint8_t* to) const override {
    if (bytes > 0) std::memcpy(to, data_ + offset, bytes);
    return true;
  }

  const uint8_t* data_;
  uint64_t bytes_;
};

}  // namespace

void ByteSource::CheckInside(uint64_t offset, uint64_t bytes) const {
  TVL_CHECK_INPUT(offset <= size() && bytes <= size() - offset)
      << name() << ": byte " << offset << ": " << bytes << " bytes are wanted, the file has "
      << size() << " in all: cut off or damaged";
}

void ByteSource::Read(uint64_t offset, size_t bytes, uint8_t* to) const {
  CheckInside(offset, bytes);
  TVL_CHECK_INPUT(ReadInside(offset, bytes, to))
      << name() << ": byte " << offset << ": cannot be read";
}

std::vector<uint8_t> ByteSource::Read(uint64_t offset, uint64_t bytes) const {
  CheckInside(offset, bytes);
  std::vector<uint8_t> read(bytes);
  Read(offset, read.size(), read.data());
  return read;
}

std::unique_ptr<ByteSource> OpenFileSource(const std::string& path) {
  return std::make_unique<FileSource>(path);
}

std::unique_ptr<ByteSource> MemorySource(const std::string& name, const uint8_t* data,
                                         uint64_t bytes) {
  return std::make_unique<Memory>(name, data, bytes);
}

SourceCursor::SourceCursor(const ByteSource& source, uint64_t begin, uint64_t end,
                           size_t window_bytes)
    : source_(source),
      position_(std::min({begin, end, source.size()})),
      end_(std::min(end, source.size())),
      window_bytes_(window_bytes) {}

void SourceCursor::CheckLeft(uint64_t bytes) const {
  TVL_CHECK_INPUT(bytes <= remaining())
      << source_.name() << ": byte " << position_ << ": a record of " << bytes
      << " bytes is announced, " << remaining() << " are left: cut off or damaged";
}

const uint8_t* SourceCursor::Peek(size_t bytes) {
  CheckLeft(bytes);
  const bool inside =
      position_ >= window_begin_ && position_ + bytes <= window_begin_ + window_.size();
  if (!inside) {
    const uint64_t ahead = std::min<uint64_t>(std::max(bytes, window_bytes_), remaining());
    window_.resize(ahead);
    source_.Read(position_, window_.size(), window_.data());
    window_begin_ = position_;
  }
  return window_.data() + (position_ - window_begin_);
}

const uint8_t* SourceCursor::Take(size_t bytes) {
  const uint8_t* data = Peek(bytes);
  position_ += bytes;
  return data;
}

void SourceCursor::Skip(uint64_t bytes) {
  CheckLeft(bytes);
  position_ += bytes;
}

}  // namespace tvl
