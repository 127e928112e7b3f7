// A labelled scan (paper Fig. 4).
#pragma once

#include <opencv2/core/mat.hpp>

#include "tvl/frame/segmented_scan.h"

namespace tvl {

// Above the range image unrolled (left is left, the middle faces forward), below the view from
// above, 50 m ahead to 30 m behind. Ground white, clusters green (small) to red (large), outliers
// blue. 8-bit BGR, 1200 px wide.
cv::Mat DrawSegments(const SegmentedScan& scan);

}  // namespace tvl
