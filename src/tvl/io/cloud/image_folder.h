// Images beside the scans of a folder.
#pragma once

#include <string>
#include <vector>

#include "tvl/io/cloud/stamps.h"
#include "tvl/io/recording.h"

namespace tvl {

// The first of the sub folders of `root` with a usual name (image_2, images, cam0/data, left ...)
// that holds .png, .jpg or .jpeg files; empty: none.
std::string FindImageFolder(const std::string& root);

// The number of a camera that the name of its folder ends with (image_2, image_02/data); -1: none.
int CameraNumberOf(const std::string& image_folder);

// Sets `images`, and notes and warnings about them, of a recording whose scans are these files with
// these stamps. Images that nothing pairs with the scans are left out with a warning.
void AddImages(const std::string& root, const std::string& image_folder,
               const std::vector<std::string>& scans, const StampsRead& scan_stamps,
               Recording* recording);

// Sets `camera` and `T_cam_lidar` from the calib.txt (KITTI odometry format) of `root`, if there is
// one; of another format it is left alone with a warning.
void AddCalibration(const std::string& root, const std::string& image_folder, Recording* recording);

}  // namespace tvl
