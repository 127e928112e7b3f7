// For tests: the small bags of tests/data/bags, and bytes to break them.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace tvl {

inline std::string BagPath(const std::string& name) {
  return std::string(TVL_TEST_BAGS) + "/" + name;
}

inline std::string ReadBytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Serialises by hand, little-endian: ROS 1, or with Align also CDR.
class BytesBuilder {
 public:
  template <typename T>
  BytesBuilder& Add(T value) {
    if (cdr_) Align(sizeof(T));
    const size_t begin = bytes_.size();
    bytes_.resize(begin + sizeof(T));
    std::memcpy(bytes_.data() + begin, &value, sizeof(T));
    return *this;
  }
  BytesBuilder& Text(const std::string& text) {
    Add<uint32_t>(static_cast<uint32_t>(text.size()) + (cdr_ ? 1U : 0U));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    if (cdr_) bytes_.push_back(0);
    return *this;
  }
  BytesBuilder& Raw(const std::vector<uint8_t>& raw) {
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    return *this;
  }
  // The header every sensor message begins with.
  BytesBuilder& Header(uint32_t seconds, uint32_t nanoseconds, const std::string& frame) {
    if (!cdr_) Add<uint32_t>(7);  // sequence number
    return Add(seconds).Add(nanoseconds).Text(frame);
  }
  static BytesBuilder Cdr() {
    BytesBuilder builder;
    builder.bytes_ = {0, 1, 0, 0};
    builder.cdr_ = true;
    return builder;
  }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  void Align(size_t size) {
    while ((bytes_.size() - 4) % size != 0) bytes_.push_back(0);
  }

  std::vector<uint8_t> bytes_;
  bool cdr_ = false;
};

}  // namespace tvl
