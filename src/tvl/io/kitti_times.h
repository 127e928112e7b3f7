// Time stamps as KITTI writes them.
#pragma once

#include <string>
#include <vector>

#include "tvl/base/time.h"

namespace tvl {

// times.txt of the odometry layout: seconds, one a line. Throws InputError naming file and line.
std::vector<Timestamp> ReadOdometryTimes(const std::string& path);

// timestamps.txt of the raw layout: "2011-09-26 13:02:25.964389445" a line; since 1970, to the
// nanosecond. Throws InputError naming file and line.
std::vector<Timestamp> ReadRawTimestamps(const std::string& path);

}  // namespace tvl
