// Numbers and texts of a serialised message, every one checked against the bytes that are there.
// Sources: ROS 1 serialisation (wiki.ros.org/msg), the CDR of the OMG's DDSI-RTPS specification
// (section 10, "plain CDR" as ROS 2 writes it), and the MCAP specification, whose records are laid
// out as ROS 1 messages are.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace tvl {

enum class MessageEncoding {
  kRos1,   // little-endian, packed
  kCdr,    // 4 bytes that tell the byte order, then numbers aligned to their own size
  kOther,  // none of what is read here
};

// A cursor over the bytes of one message. All reads throw InputError, beginning with `source` and
// naming the byte, where the message ends too early. Does not copy the bytes or the name: they must
// outlive the reader.
class WireReader {
 public:
  // Throws InputError for an encapsulation other than plain CDR.
  WireReader(const uint8_t* data, size_t bytes, MessageEncoding encoding, std::string_view source);

  template <typename T>
  T Number() {
    Align(sizeof(T));
    std::array<uint8_t, sizeof(T)> copy;
    std::memcpy(copy.data(), Bytes(sizeof(T)), sizeof(T));
    if (big_endian_ != kHostIsBigEndian) std::reverse(copy.begin(), copy.end());
    T value;
    std::memcpy(&value, copy.data(), sizeof(T));
    return value;
  }
  std::string String();
  // The next bytes as they stand; the pointer is into the message.
  const uint8_t* Bytes(size_t count);
  // Length of a sequence whose elements take at least `least_bytes` each: a length for which the
  // message is too short is an error here, before anything of that size is allocated.
  uint32_t Count(size_t least_bytes);
  // In CDR, moves to the next multiple of `size` (a power of two); nothing in ROS 1.
  void Align(size_t size);

  size_t position() const { return position_; }
  size_t remaining() const { return bytes_ - position_; }
  bool big_endian() const { return big_endian_; }
  MessageEncoding encoding() const { return encoding_; }

 private:
  static constexpr bool kHostIsBigEndian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

  const uint8_t* data_;
  size_t bytes_;
  size_t position_ = 0;
  MessageEncoding encoding_;
  bool big_endian_ = false;
  std::string_view source_;
};

}  // namespace tvl
