// What loops did to trajectory and map (paper Fig. 13 and 14).
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "tvl/map/map.h"
#include "tvl/slam/loop_types.h"

namespace tvl {

// The driven line as the odometry has it (grey) and with loops (white), seen from above; accepted
// loops green, loops dropped in the end red. 8-bit BGR.
cv::Mat DrawLoops(const std::vector<Keyframe>& keyframes, const LoopReport& report);

// Accepted loops whose places are far apart from one another, those that the loops moved most
// first: indices into report.records.
std::vector<size_t> MostTelling(const std::vector<Keyframe>& keyframes, const LoopReport& report,
                                size_t count);

// One place before (left) and after (right) loop closing: what the earlier pass saw in blue, what
// the later one saw in orange. Where walls lie on each other the map is right.
cv::Mat DrawPlace(const Map& map, const LoopRecord& loop);

}  // namespace tvl
