#include "tvl/io/ros/ros1_record.h"

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Headers hold a topic and a few numbers; a longer one is damaged.
constexpr uint32_t kMostHeaderBytes = uint32_t{1} << 16;

uint32_t TakeLength(SourceCursor* cursor) {
  WireReader reader(cursor->Take(4), 4, MessageEncoding::kRos1, cursor->source().name());
  return reader.Number<uint32_t>();
}

}  // namespace

Ros1Fields::Ros1Fields(const uint8_t* data, size_t bytes, const std::string& source)
    : header_(reinterpret_cast<const char*>(data), bytes), source_(source) {
  WireReader reader(data, bytes, MessageEncoding::kRos1, source_);
  while (reader.remaining() > 0) {
    const std::string field = reader.String();
    TVL_CHECK_INPUT(field.find('=') != std::string::npos)
        << source_ << ": a header field without '=': damaged";
  }
}

std::string_view Ros1Fields::Find(std::string_view name) const {
  const auto* data = reinterpret_cast<const uint8_t*>(header_.data());
  WireReader reader(data, header_.size(), MessageEncoding::kRos1, source_);
  while (reader.remaining() > 0) {
    const uint32_t length = reader.Count(1);
    const std::string_view field(reinterpret_cast<const char*>(reader.Bytes(length)), length);
    const size_t equal = field.find('=');
    if (field.substr(0, equal) == name) return field.substr(equal + 1);
  }
  return {};
}

std::string_view Ros1Fields::Value(std::string_view name, size_t bytes) const {
  const std::string_view value = Find(name);
  TVL_CHECK_INPUT(value.size() == bytes)
      << source_ << ": header field '" << name << "' of " << bytes << " bytes is missing: damaged";
  return value;
}

Timestamp Ros1Fields::Time(std::string_view name) const {
  const auto packed = Number<uint64_t>(name);  // seconds in the low half, nanoseconds in the high
  return {static_cast<int64_t>(packed & 0xFFFFFFFFU) * 1'000'000'000 +
          static_cast<int64_t>(packed >> 32U)};
}

Ros1Record ReadRos1Record(SourceCursor* cursor) {
  const std::string& name = cursor->source().name();
  const uint64_t begin = cursor->position();
  const uint32_t header_bytes = TakeLength(cursor);
  TVL_CHECK_INPUT(header_bytes <= kMostHeaderBytes)
      << name << ": byte " << begin << ": a record header of " << header_bytes << " bytes: damaged";
  Ros1Fields fields(cursor->Take(header_bytes), header_bytes,
                    name + ": byte " + std::to_string(begin));
  const uint32_t data_bytes = TakeLength(cursor);
  return {std::move(fields), cursor->position(), data_bytes};
}

}  // namespace tvl
