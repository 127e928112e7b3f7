#include "tvl/io/cloud/lzf.h"

#include "tvl/base/check.h"

namespace tvl {
namespace {

// A copy of the longest kind takes three bytes and yields 264.
constexpr size_t kMostGrowth = 264 / 3;

// The output grows up to `most` bytes; every step checks what it reads and what it writes.
class Unpacker {
 public:
  Unpacker(const uint8_t* packed, size_t bytes, size_t most, std::string source)
      : packed_(packed), bytes_(bytes), most_(most), source_(std::move(source)) {
    out_.reserve(most);
  }

  std::vector<uint8_t> Run() && {
    while (at_ < bytes_) {
      const size_t control = NextByte();
      if (control < 32) {
        Literals(control + 1);
      } else {
        size_t length = (control >> 5) + 2;
        if (length == 9) length += NextByte();
        const size_t distance = ((control & 31) << 8 | NextByte()) + 1;
        Copy(distance, length);
      }
    }
    Check(out_.size() == most_, "the data end too early");
    return std::move(out_);
  }

 private:
  void Check(bool good, const char* what) const {
    TVL_CHECK_INPUT(good) << source_ << ": compressed byte " << at_ << " of " << bytes_ << ": "
                          << what << " (" << out_.size() << " bytes unpacked, " << most_
                          << " announced)";
  }
  size_t NextByte() {
    Check(at_ < bytes_, "the data break off");
    return packed_[at_++];
  }
  void Literals(size_t length) {
    Check(length <= bytes_ - at_, "the data break off");
    Check(length <= most_ - out_.size(), "more data than announced");
    out_.insert(out_.end(), packed_ + at_, packed_ + at_ + length);
    at_ += length;
  }
  // One by one, because the source may overlap what is being written: that is how runs are packed.
  void Copy(size_t distance, size_t length) {
    Check(distance <= out_.size(), "refers to data before the beginning");
    Check(length <= most_ - out_.size(), "more data than announced");
    for (size_t i = 0; i < length; ++i) out_.push_back(out_[out_.size() - distance]);
  }

  const uint8_t* packed_;
  size_t bytes_, most_, at_ = 0;
  std::string source_;
  std::vector<uint8_t> out_;
};

}  // namespace

std::vector<uint8_t> UnpackLzf(const uint8_t* packed, size_t packed_bytes, size_t unpacked_bytes,
                               const std::string& source) {
  TVL_CHECK_INPUT(unpacked_bytes / kMostGrowth <= packed_bytes)
      << source << ": " << packed_bytes << " compressed bytes cannot hold the " << unpacked_bytes
      << " bytes that are announced";
  return Unpacker(packed, packed_bytes, unpacked_bytes, source).Run();
}

}  // namespace tvl
