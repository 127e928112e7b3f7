#include "tvl/io/ros/point_messages.h"

#include <algorithm>
#include <array>
#include <optional>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Sizes of a field: name, offset, datatype and count, the name empty.
constexpr size_t kLeastFieldBytes = 4 + 4 + 1 + 4;
// One point of a Livox message without padding: time, x, y, z, reflectivity, tag, line.
constexpr size_t kLivoxPointBytes = 19;
// In CDR the next point begins at a multiple of 4.
constexpr size_t kLivoxStepCdrBytes = 20;

// By sensor_msgs/PointField; empty for numbers that it does not have.
std::optional<NumberType> TypeOfDatatype(uint8_t datatype) {
  constexpr std::array<NumberType, 8> kTypes = {
      NumberType::kInt8,  NumberType::kUint8,  NumberType::kInt16,   NumberType::kUint16,
      NumberType::kInt32, NumberType::kUint32, NumberType::kFloat32, NumberType::kFloat64};
  if (datatype < 1 || datatype > kTypes.size()) return std::nullopt;
  return kTypes[datatype - 1U];
}

std::vector<PointField> ReadFields(WireReader* reader) {
  std::vector<PointField> fields;
  const uint32_t count = reader->Count(kLeastFieldBytes);
  for (uint32_t k = 0; k < count; ++k) {
    PointField field;
    field.name = reader->String();
    field.offset = reader->Number<uint32_t>();
    const std::optional<NumberType> type = TypeOfDatatype(reader->Number<uint8_t>());
    field.count = reader->Number<uint32_t>();
    if (!type) continue;  // padding, in some drivers
    field.type = *type;
    fields.push_back(std::move(field));
  }
  return fields;
}

PointsMessage DecodePointCloud2(const StoredMessage& message) {
  WireReader reader = message.Reader();
  PointsMessage decoded;
  decoded.header = ReadHeader(&reader);
  PointTable table;
  table.height = reader.Number<uint32_t>();
  table.width = reader.Number<uint32_t>();
  table.fields = ReadFields(&reader);
  table.big_endian = reader.Number<uint8_t>() != 0;
  table.point_step = reader.Number<uint32_t>();
  table.row_step = reader.Number<uint32_t>();
  table.bytes = reader.Count(1);
  table.data = reader.Bytes(table.bytes);
  // Some drivers fill the row step with nonsense; where the points fill the data to the last byte,
  // there is but one way to read them. No overflow: all three are 32 bit, and the last only counts
  // if the product is small.
  const size_t row_bytes = table.width * table.point_step;
  if (row_bytes > 0 && table.bytes / row_bytes == table.height && table.bytes % row_bytes == 0) {
    table.row_step = row_bytes;
  }
  decoded.scan = DecodePoints(table, message.place);
  decoded.fields = std::move(table.fields);
  return decoded;
}

PointsMessage DecodeLivox(const StoredMessage& message) {
  WireReader reader = message.Reader();
  PointsMessage decoded;
  decoded.header = ReadHeader(&reader);
  reader.Number<uint64_t>();  // instant of the first point
  reader.Number<uint32_t>();  // number of points, said again by the sequence
  reader.Bytes(1 + 3);        // lidar and reserved
  PointTable table;
  const bool cdr = message.encoding == MessageEncoding::kCdr;
  table.point_step = cdr ? kLivoxStepCdrBytes : kLivoxPointBytes;
  table.width = reader.Count(kLivoxPointBytes);
  table.big_endian = reader.big_endian();
  table.fields = {{"offset_time", 0, NumberType::kUint32, 1},  {"x", 4, NumberType::kFloat32, 1},
                  {"y", 8, NumberType::kFloat32, 1},           {"z", 12, NumberType::kFloat32, 1},
                  {"reflectivity", 16, NumberType::kUint8, 1}, {"tag", 17, NumberType::kUint8, 1},
                  {"line", 18, NumberType::kUint8, 1}};
  // The last point has no padding behind it: the copy has.
  const size_t bytes = table.width * table.point_step;
  const size_t stored = std::min(bytes, reader.remaining());
  TVL_CHECK_INPUT(bytes - stored <= table.point_step - kLivoxPointBytes)
      << message.place << ": " << table.width << " points in " << stored << " bytes: cut off?";
  std::vector<uint8_t> copy(bytes);
  std::copy_n(reader.Bytes(stored), stored, copy.begin());
  table.bytes = copy.size(), table.data = copy.data();
  decoded.scan = DecodePoints(table, message.place);
  decoded.fields = std::move(table.fields);
  return decoded;
}

const char* NameOf(NumberType type) {
  switch (type) {
    case NumberType::kInt8:
      return "int8";
    case NumberType::kUint8:
      return "uint8";
    case NumberType::kInt16:
      return "int16";
    case NumberType::kUint16:
      return "uint16";
    case NumberType::kInt32:
      return "int32";
    case NumberType::kUint32:
      return "uint32";
    case NumberType::kInt64:
      return "int64";
    case NumberType::kUint64:
      return "uint64";
    case NumberType::kFloat32:
      return "float32";
    case NumberType::kFloat64:
      return "float64";
  }
  throw Error("number type that does not exist");
}

}  // namespace

PointsMessage DecodePointsMessage(MessageKind kind, const StoredMessage& message) {
  TVL_CHECK(kind == MessageKind::kPointCloud2 || kind == MessageKind::kLivoxPoints);
  return kind == MessageKind::kPointCloud2 ? DecodePointCloud2(message) : DecodeLivox(message);
}

std::string DescribeFields(const std::vector<PointField>& fields) {
  std::string text;
  for (const PointField& field : fields) {
    text += (text.empty() ? "" : ", ") + field.name + " " + NameOf(field.type);
  }
  return text;
}

}  // namespace tvl
