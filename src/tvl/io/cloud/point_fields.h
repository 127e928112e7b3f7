// Points as records of named fields: what PCD, PLY, LAS, .bin files and ROS PointCloud2 messages
// have in common. Each format fills a PointTable; DecodePoints turns it into a RawScan.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tvl/sensor/raw_scan.h"

namespace tvl {

// More than any scan has: 16 million points.
inline constexpr size_t kMostPoints = size_t{1} << 24;

enum class NumberType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
};

// Bytes of one number.
size_t SizeOf(NumberType type);

// The number that begins at `bytes`, of which SizeOf(type) are read. Whole numbers of 64 bits keep
// 53 of them.
double NumberAt(const uint8_t* bytes, NumberType type, bool big_endian);

struct PointField {
  std::string name;
  size_t offset = 0;  // of the first byte within a record
  NumberType type = NumberType::kFloat32;
  size_t count = 1;  // numbers of that type; only the first is ever read
};

// Records side by side in memory that belongs to somebody else.
struct PointTable {
  std::vector<PointField> fields;
  size_t width = 0, height = 1;  // records a row, and rows
  size_t point_step = 0;         // bytes from one record to the next
  size_t row_step = 0;           // bytes from one row to the next
  bool big_endian = false;
  const uint8_t* data = nullptr;
  size_t bytes = 0;  // that may be read from `data`
};

// Recognised, in this order and without regard to case: x, y, z (needed); intensity, i,
// reflectivity, remission, reflectance, signal; ring, line, channel, laser_id, beam; t, time,
// timestamp, time_stamp, offset_time, time_offset, point_time_offset, gps_time, gpstime. Rings
// beyond 65535 or negative, and times that are not finite, make the field unusable: it is left out.
// Throws InputError beginning with `source` for tables that contradict themselves: fields beyond
// the record, rows beyond `bytes`, no x, y or z, more than 16 million points.
RawScan DecodePoints(const PointTable& table, const std::string& source);

}  // namespace tvl
