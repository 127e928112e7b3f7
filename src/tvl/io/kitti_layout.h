// Finds out what a KITTI folder holds, without reading scans or images.
//
// Odometry layout: velodyne/NNNNNN.bin, any of image_0..image_3/NNNNNN.png|jpg, calib.txt,
// times.txt (s, a line a frame), optionally poses.txt (truth: T_first_cam0, 3x4 a line) and
// tvl.yaml. Raw layout (DATE/DATE_drive_NNNN_sync): velodyne_points/data, image_00..image_03/data,
// timestamps.txt beside each data folder, calib_*.txt in the date folder.
//
// tvl.yaml has one key: `deskew: none|cw|ccw`, what is known of the scans' motion compensation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tvl/base/time.h"
#include "tvl/io/kitti_calibration.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl {

struct KittiFrameFiles {
  int64_t number = 0;      // of the files
  Timestamp stamp;         // of the image; of the scan where there are no images
  std::string scan_path;   // empty: no such file
  std::string image_path;  // empty: no such file
};

struct KittiLayout {
  std::string folder;
  std::string name;  // of the folder
  bool is_raw = false;
  int camera = -1;  // 0..3, -1: no images
  KittiCalibration calibration;
  // Every file number from the first scan to the last; numbers without a file are there too.
  std::vector<KittiFrameFiles> frames;
  std::vector<Rigid3d> truth_T_first_cam0;  // one a frame or empty
  std::optional<Deskew> deskew;             // from tvl.yaml
  size_t missing_scans = 0, missing_images = 0;
  std::vector<std::string> warnings;  // about the folder as a whole
};

// Whether `folder` has the scans and the calibration of one of the two layouts where they belong.
// Looks at names only.
bool LooksLikeKitti(const std::string& folder);

// `camera`: 0..3, or -1 for the lowest that has images. Frames are paired by file number; missing
// files are counted. Throws InputError naming the folder or file: no folder, no scans, no
// calibration, malformed text files, a camera asked for that has no images.
KittiLayout FindKittiLayout(const std::string& folder, int camera = -1);

}  // namespace tvl
