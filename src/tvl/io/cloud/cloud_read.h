// What a reader of a cloud file delivers, and the bytes it reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tvl/io/cloud/point_fields.h"
#include "tvl/sensor/raw_scan.h"

namespace tvl {

struct CloudRead {
  RawScan scan;
  std::vector<std::string> notes;  // what of the file is not in the scan; they name no file
};

// No cloud file and nothing unpacked from one may be larger: 1 GiB, which holds the 16 million
// points of the largest scan at 64 bytes each.
inline constexpr size_t kMostCloudBytes = size_t{1} << 30;

// The bytes of a file. Throws InputError beginning with the path: not there, a folder, too large.
std::vector<uint8_t> ReadFileBytes(const std::string& path);

// The little-endian number at `offset`. Throws InputError beginning with `source` and naming the
// offset where it lies beyond the `bytes`.
uint16_t LittleUint16At(const uint8_t* data, size_t bytes, size_t offset,
                        const std::string& source);
uint32_t LittleUint32At(const uint8_t* data, size_t bytes, size_t offset,
                        const std::string& source);
uint64_t LittleUint64At(const uint8_t* data, size_t bytes, size_t offset,
                        const std::string& source);
double LittleDoubleAt(const uint8_t* data, size_t bytes, size_t offset, const std::string& source);

// Points that were text: `numbers` holds one number a field name, point after point. `table` reads
// from `numbers`, which must outlive it. Throws InputError beginning with `source` where width *
// height points are not what `numbers` holds.
PointTable TableOfNumbers(const std::vector<std::string>& names, const std::vector<double>& numbers,
                          size_t width, size_t height, const std::string& source);

}  // namespace tvl
