// Scans in LAS files, versions 1.0 to 1.4, point formats 0 to 10. LAZ is refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "tvl/io/cloud/cloud_read.h"

namespace tvl {

// The points of a LAS file in memory: x, y, z (m), the intensity as stored (0 to 65535) and, for
// the formats that have it, the GPS time (s) as `gps_time`. Coordinates of which float32 would lose
// millimetres (beyond 8192 m) are given relative to the offset of the header, or to the first point
// where that is not enough; a note says so. Throws InputError beginning with `source` and naming
// the byte: no LAS file, compressed (LAZ), headers that contradict the file's length, scales that
// are no numbers, more than 16 million points.
CloudRead ParseLas(const uint8_t* data, size_t bytes, const std::string& source);

// ParseLas of a file. Throws InputError beginning with `path`.
CloudRead ReadLasScan(const std::string& path);

}  // namespace tvl
