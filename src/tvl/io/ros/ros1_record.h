// Records of a ROS 1 bag, format 2.0 (wiki.ros.org/Bags/Format/2.0).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tvl/base/time.h"
#include "tvl/io/ros/byte_source.h"
#include "tvl/io/ros/wire.h"

namespace tvl {

// Values of the field "op".
enum class Ros1Op : uint8_t {
  kMessage = 2,
  kBagHeader = 3,
  kIndexData = 4,
  kChunk = 5,
  kChunkInfo = 6,
  kConnection = 7,
};

// The header of a record or of a connection: fields "name=value", each after its length.
class Ros1Fields {
 public:
  // Copies. Throws InputError beginning with `source` for fields that leave the header.
  Ros1Fields(const uint8_t* data, size_t bytes, const std::string& source);

  // Throws InputError if there is no such field or it has another size.
  template <typename T>
  T Number(std::string_view name) const {
    const std::string_view value = Value(name, sizeof(T));
    WireReader reader(reinterpret_cast<const uint8_t*>(value.data()), value.size(),
                      MessageEncoding::kRos1, source_);
    return reader.Number<T>();
  }
  Timestamp Time(std::string_view name) const;
  Ros1Op Op() const { return static_cast<Ros1Op>(Number<uint8_t>("op")); }
  // Empty if there is no such field.
  std::string Text(std::string_view name) const { return std::string(Find(name)); }

 private:
  std::string_view Find(std::string_view name) const;
  std::string_view Value(std::string_view name, size_t bytes) const;

  std::string header_;
  std::string source_;
};

struct Ros1Record {
  Ros1Fields fields;
  uint64_t data_offset;  // in the source
  uint32_t data_bytes;   // as announced: may reach beyond the end
};

// Reads the header and leaves the cursor at the data. Throws InputError with the offset.
Ros1Record ReadRos1Record(SourceCursor* cursor);

}  // namespace tvl
