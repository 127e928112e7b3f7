// The layout of KITTI's object benchmark: training/{velodyne,image_2,calib} (or testing/), one
// calibration file a frame. Its frames are single ones of many drives, unless the folder was filled
// with a sequence.
#pragma once

#include <string>

#include "tvl/io/kitti_calibration.h"
#include "tvl/io/recording.h"

namespace tvl {

// calib/NNNNNN.txt: P0..P3, R0_rect and Tr_velo_to_cam. Tr_velo_to_cam leads into camera 0 before
// rectification: T_cam0_lidar = R0_rect Tr_velo_to_cam. Throws InputError naming file, line and
// key.
KittiCalibration ReadObjectCalibration(const std::string& path);

// Whether `path` is such a folder or has one called training or testing. Looks at names only.
bool LooksLikeKittiObject(const std::string& path);

// Of training/ where both are there. Scans without stamps, the images of camera 2 (else of the
// lowest that has some) by number. All frames have the first's calibration; a warning counts those
// whose own differs. Throws InputError naming folder or file: no scans, no calibration, a malformed
// first one.
Recording OpenKittiObject(const std::string& path);

}  // namespace tvl
