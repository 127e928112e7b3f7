// Scans in PCD files, versions 0.5 to 0.7, of any writer: DATA ascii, binary or binary_compressed,
// fields of any name and type. io/point_cloud_io.h has the files that this project writes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "tvl/io/cloud/cloud_read.h"

namespace tvl {

// The points of a PCD file in memory. Fields are recognised by name (point_fields.h); of a field
// with COUNT > 1 the first number is used. A VIEWPOINT other than the identity is noted and not
// applied: the points stay as stored. Throws InputError beginning with `source` and naming the line
// or byte: headers that are incomplete or contradict themselves or the data, data that are cut off,
// compressed data that do not unpack to the size of the points.
CloudRead ParsePcd(const uint8_t* data, size_t bytes, const std::string& source);

// ParsePcd of a file. Throws InputError beginning with `path`.
CloudRead ReadPcdScan(const std::string& path);

}  // namespace tvl
