// Scans in PLY files of any writer: ascii, binary little and big endian. io/point_cloud_io.h has
// the files that this project writes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "tvl/io/cloud/cloud_read.h"

namespace tvl {

// The points of a PLY file in memory: the scalar properties of the element `vertex`, recognised by
// name (point_fields.h; a prefix `scalar_`, as CloudCompare writes it, is dropped). List properties
// and other elements are skipped; what follows the vertices is not looked at. Throws InputError
// beginning with `source` and naming the line or byte: headers that are incomplete, of unknown
// types or contradict the data, lists of negative length, data that are cut off.
CloudRead ParsePly(const uint8_t* data, size_t bytes, const std::string& source);

// ParsePly of a file. Throws InputError beginning with `path`.
CloudRead ReadPlyScan(const std::string& path);

}  // namespace tvl
