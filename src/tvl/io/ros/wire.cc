#include "tvl/io/ros/wire.h"

#include "tvl/base/check.h"

namespace tvl {
namespace {

// The encapsulation header: two bytes of representation and two of options. Alignment counts from
// its end.
constexpr size_t kCdrHeaderBytes = 4;

}  // namespace

WireReader::WireReader(const uint8_t* data, size_t bytes, MessageEncoding encoding,
                       std::string_view source)
    : data_(data), bytes_(bytes), encoding_(encoding), source_(source) {
  if (encoding_ != MessageEncoding::kCdr) return;
  const uint8_t* header = Bytes(kCdrHeaderBytes);
  TVL_CHECK_INPUT(header[0] == 0 && header[1] <= 1)
      << source_ << ": CDR representation " << int{header[0]} << "." << int{header[1]}
      << " is not plain CDR (0.0 or 0.1), as ROS 2 writes it";
  big_endian_ = header[1] == 0;
}

const uint8_t* WireReader::Bytes(size_t count) {
  TVL_CHECK_INPUT(count <= remaining())
      << source_ << ": byte " << position_ << " of the message: " << count << " bytes expected, "
      << remaining() << " left";
  const uint8_t* begin = data_ + position_;
  position_ += count;
  return begin;
}

std::string WireReader::String() {
  const uint32_t length = Count(1);
  std::string text(reinterpret_cast<const char*>(Bytes(length)), length);
  // CDR counts the zero at the end; ROS 1 has none.
  if (encoding_ == MessageEncoding::kCdr && !text.empty() && text.back() == '\0') text.pop_back();
  return text;
}

uint32_t WireReader::Count(size_t least_bytes) {
  const auto count = Number<uint32_t>();
  TVL_CHECK_INPUT(count <= remaining() / std::max<size_t>(least_bytes, 1))
      << source_ << ": byte " << position_ << " of the message: a sequence of " << count
      << " elements does not fit into the " << remaining() << " bytes left";
  return count;
}

void WireReader::Align(size_t size) {
  if (encoding_ != MessageEncoding::kCdr) return;
  const size_t over = (position_ - kCdrHeaderBytes) % size;
  if (over != 0) Bytes(size - over);
}

}  // namespace tvl
