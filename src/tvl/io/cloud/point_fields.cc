#include "tvl/io/cloud/point_fields.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <initializer_list>

#include "tvl/base/check.h"

namespace tvl {
namespace {

std::string LowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// The first of `names` that is a field; null if none is.
const PointField* Find(const PointTable& table, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    for (const PointField& field : table.fields) {
      if (LowerCase(field.name) == name) return &field;
    }
  }
  return nullptr;
}

template <typename T>
double Load(const uint8_t* bytes, bool swap) {
  std::array<uint8_t, sizeof(T)> copy;
  std::memcpy(copy.data(), bytes, sizeof(T));
  if (swap) std::reverse(copy.begin(), copy.end());
  T value;
  std::memcpy(&value, copy.data(), sizeof(T));
  return static_cast<double>(value);
}

// Calls visit(index, value) for one field of all records, in order.
template <typename Visit>
void ForEach(const PointTable& table, const PointField& field, const Visit& visit) {
  if (table.width == 0) return;  // with any height: no data need be there
  size_t i = 0;
  for (size_t row = 0; row < table.height; ++row) {
    const uint8_t* record = table.data + row * table.row_step + field.offset;
    for (size_t column = 0; column < table.width; ++column, record += table.point_step) {
      visit(i++, NumberAt(record, field.type, table.big_endian));
    }
  }
}

// Throws InputError where reading the table would leave its bytes. Written with divisions, so that
// no product overflows.
void CheckTable(const PointTable& table, const std::string& source) {
  TVL_CHECK_INPUT(table.width == 0 || table.height <= kMostPoints / table.width)
      << source << ": " << table.width << " x " << table.height
      << " points: more than any scan has (" << kMostPoints << ")";
  for (const PointField& field : table.fields) {
    TVL_CHECK_INPUT(field.offset <= table.point_step &&
                    SizeOf(field.type) <= table.point_step - field.offset)
        << source << ": field '" << field.name << "' at byte " << field.offset
        << " lies beyond the " << table.point_step << " bytes of a point";
  }
  if (table.width == 0 || table.height == 0) return;
  const size_t most_points = table.bytes / std::max<size_t>(table.point_step, 1);
  TVL_CHECK_INPUT(table.point_step > 0 && table.width <= most_points)
      << source << ": " << table.width << " points of " << table.point_step
      << " bytes do not fit into " << table.bytes << " bytes: cut off?";
  const size_t row_bytes = table.width * table.point_step;
  if (table.height == 1) return;
  TVL_CHECK_INPUT(table.row_step >= row_bytes &&
                  (table.height - 1) <= (table.bytes - row_bytes) / table.row_step)
      << source << ": " << table.height << " rows of " << table.row_step
      << " bytes do not fit into " << table.bytes << " bytes: cut off?";
}

void DecodeRings(const PointTable& table, const PointField& field, RawScan* scan) {
  scan->ring.resize(scan->size());
  bool fits = true;
  ForEach(table, field, [&](size_t i, double value) {
    fits = fits && value >= 0.0 && value <= 65535.0;
    scan->ring[i] = fits ? static_cast<uint16_t>(value) : uint16_t{0};
  });
  if (!fits) return scan->ring.clear();
  scan->ring_field = field.name;
}

void DecodeTimes(const PointTable& table, const PointField& field, RawScan* scan) {
  scan->time.resize(scan->size());
  bool fits = true;
  ForEach(table, field, [&](size_t i, double value) {
    fits = fits && std::isfinite(value);
    scan->time[i] = value;
  });
  if (!fits) return scan->time.clear();
  scan->time_field = field.name;
}

}  // namespace

size_t SizeOf(NumberType type) {
  switch (type) {
    case NumberType::kInt8:
    case NumberType::kUint8:
      return 1;
    case NumberType::kInt16:
    case NumberType::kUint16:
      return 2;
    case NumberType::kInt32:
    case NumberType::kUint32:
    case NumberType::kFloat32:
      return 4;
    case NumberType::kInt64:
    case NumberType::kUint64:
    case NumberType::kFloat64:
      return 8;
  }
  throw Error("number type that does not exist");
}

double NumberAt(const uint8_t* bytes, NumberType type, bool big_endian) {
  switch (type) {
    case NumberType::kInt8:
      return Load<int8_t>(bytes, big_endian);
    case NumberType::kUint8:
      return Load<uint8_t>(bytes, big_endian);
    case NumberType::kInt16:
      return Load<int16_t>(bytes, big_endian);
    case NumberType::kUint16:
      return Load<uint16_t>(bytes, big_endian);
    case NumberType::kInt32:
      return Load<int32_t>(bytes, big_endian);
    case NumberType::kUint32:
      return Load<uint32_t>(bytes, big_endian);
    case NumberType::kInt64:
      return Load<int64_t>(bytes, big_endian);
    case NumberType::kUint64:
      return Load<uint64_t>(bytes, big_endian);
    case NumberType::kFloat32:
      return Load<float>(bytes, big_endian);
    case NumberType::kFloat64:
      return Load<double>(bytes, big_endian);
  }
  throw Error("number type that does not exist");
}

RawScan DecodePoints(const PointTable& table, const std::string& source) {
  CheckTable(table, source);
  const std::array<const PointField*, 3> axes = {Find(table, {"x"}), Find(table, {"y"}),
                                                 Find(table, {"z"})};
  for (const PointField* axis : axes) {
    TVL_CHECK_INPUT(axis != nullptr) << source << ": no fields x, y and z";
  }
  RawScan scan;
  if (table.width == 0 || table.height == 0) return scan;
  scan.width = table.width, scan.height = table.height;
  scan.points.resize(table.width * table.height);
  for (int axis = 0; axis < 3; ++axis) {
    ForEach(table, *axes[static_cast<size_t>(axis)],
            [&](size_t i, double value) { scan.points[i][axis] = static_cast<float>(value); });
  }
  if (const PointField* field =
          Find(table, {"intensity", "i", "reflectivity", "remission", "reflectance", "signal"})) {
    scan.intensity.resize(scan.size());
    ForEach(table, *field, [&](size_t i, double value) {
      scan.intensity[i] = std::isfinite(value) ? static_cast<float>(value) : 0.0F;
    });
    scan.intensity_field = field->name;
  }
  if (const PointField* field = Find(table, {"ring", "line", "channel", "laser_id", "beam"})) {
    DecodeRings(table, *field, &scan);
  }
  if (const PointField* field =
          Find(table, {"t", "time", "timestamp", "time_stamp", "offset_time", "time_offset",
                       "point_time_offset", "gps_time", "gpstime"})) {
    DecodeTimes(table, *field, &scan);
  }
  return scan;
}

}  // namespace tvl
