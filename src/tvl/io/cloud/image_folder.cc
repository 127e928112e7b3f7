#include "tvl/io/cloud/image_folder.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/io/cloud/file_names.h"
#include "tvl/io/cloud/file_streams.h"
#include "tvl/io/kitti_calibration.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

// Pairs by name are believed where this share of the scans has one.
constexpr double kPairedShare = 0.5;

std::vector<std::string> ImagesOf(const fs::path& folder) {
  return ListFiles(folder, {".png", ".jpg", ".jpeg"});
}

// From a file in the folder or, unless that is the recording's own, beside it; else the names.
StampsRead StampsOfImages(const fs::path& root, const fs::path& folder,
                          const std::vector<std::string>& images) {
  std::vector<fs::path> folders = {folder};
  if (folder.parent_path() != root) folders.push_back(folder.parent_path());
  for (const fs::path& place : folders) {
    for (const std::string& file : ListFiles(place, {".txt", ".csv"})) {
      StampsRead read = StampsFromFile(file, images);
      if (read.stamps.empty()) continue;
      read.what = file + ": " + read.what;
      return read;
    }
  }
  StampsRead read = StampsFromNames(images);
  read.what = "file names: " + read.what;
  return read;
}

// Whether the two lie in the same stretch of time, so that they can be of one clock.
bool Overlap(const std::vector<Timestamp>& a, const std::vector<Timestamp>& b) {
  if (a.empty() || b.empty()) return false;
  const auto [a_first, a_last] = std::minmax_element(a.begin(), a.end());
  const auto [b_first, b_last] = std::minmax_element(b.begin(), b.end());
  return *a_first <= *b_last && *b_first <= *a_last;
}

// One image a scan; where there is none, the name it would have.
std::vector<std::string> WithExpectedNames(std::vector<std::string> pairs,
                                           const std::vector<std::string>& scans,
                                           const std::string& first_image) {
  const fs::path example(first_image);
  for (size_t i = 0; i < pairs.size(); ++i) {
    if (!pairs[i].empty()) continue;
    pairs[i] = (example.parent_path() / (StemOf(scans[i]) + example.extension().string())).string();
  }
  return pairs;
}

}  // namespace

std::string FindImageFolder(const std::string& root) {
  for (const char* name :
       {"image_2",       "image_02/data", "image_02",      "image_0", "image_00/data_rect",
        "image_00/data", "image_00",      "image_3",       "image_1", "images",
        "image",         "imgs",          "img",           "camera",  "camera_0",
        "camera0",       "cam0/data",     "cam0",          "cam_0",   "left",
        "left/data",     "image_left",    "left_images",   "rgb",     "color",
        "camera_front",  "front",         "cameras/front", "cam",     "png"}) {
    const fs::path folder = fs::path(root) / name;
    if (!ImagesOf(folder).empty()) return folder.string();
  }
  return {};
}

int CameraNumberOf(const std::string& image_folder) {
  for (const fs::path& part : fs::path(image_folder).lexically_normal()) {
    const std::string name = part.string();
    for (int camera = 0; camera < 4; ++camera) {
      const std::string n = std::to_string(camera);
      if (name == "image_" + n || name == "image_0" + n) return camera;
    }
  }
  return -1;
}

void AddImages(const std::string& root, const std::string& image_folder,
               const std::vector<std::string>& scans, const StampsRead& scan_stamps,
               Recording* recording) {
  const std::vector<std::string> images = ImagesOf(image_folder);
  const ImageSize size = SizeOfFirstImage(images);
  std::string note = "images: " + std::to_string(images.size()) + " in " + image_folder + ", ";
  StampsRead stamps = StampsOfImages(root, image_folder, images);
  if (Overlap(scan_stamps.stamps, stamps.stamps)) {
    recording->images = MakeFileImageStream(images, std::move(stamps.stamps), size);
    recording->notes.push_back(note + "stamps from " + stamps.what);
    return;
  }
  const std::vector<std::string> pairs = PairByName(scans, images);
  const auto missing = static_cast<size_t>(std::count(pairs.begin(), pairs.end(), std::string()));
  const auto paired = static_cast<double>(scans.size() - missing);
  if (paired >= kPairedShare * static_cast<double>(scans.size())) {
    recording->images = MakeFileImageStream(WithExpectedNames(pairs, scans, images[0]), {}, size);
    recording->notes.push_back(note + "taken with the scans of the same name or number");
    if (missing == 0) return;
    recording->warnings.push_back(image_folder + ": " + std::to_string(missing) + " images of " +
                                  std::to_string(scans.size()) + " scans are missing");
  } else if (images.size() == scans.size()) {
    recording->images = MakeFileImageStream(images, {}, size);
    recording->notes.push_back(note + "taken with the scans one by one in order of their names");
  } else {
    recording->warnings.push_back(
        image_folder + ": " + std::to_string(images.size()) + " images and " +
        std::to_string(scans.size()) +
        " scans: neither stamps of one clock nor names tell which belong together, so the images "
        "are left out (stamps of the images: " +
        stamps.what + ")");
  }
}

void AddCalibration(const std::string& root, const std::string& image_folder,
                    Recording* recording) {
  const std::string path = (fs::path(root) / "calib.txt").string();
  if (!fs::exists(path)) return;
  try {
    const KittiCalibration kitti = ReadOdometryCalibration(path);
    if (recording->images == nullptr) {
      recording->T_cam_lidar = CalibrationWithoutCamera(kitti).T_cam_lidar;
      recording->notes.push_back("calibration: " + path + ", of camera 0");
      return;
    }
    int camera = CameraNumberOf(image_folder);
    // A folder without a number is the camera the file describes, the first if it has several.
    for (int n = 0; camera < 0 && n < 4; ++n) {
      if (kitti.P[static_cast<size_t>(n)]) camera = n;
    }
    const Calibration calibration = CalibrationOfCamera(kitti, std::max(camera, 0));
    const ImageSize size = SizeOfFirstImage(ImagesOf(image_folder));
    recording->camera = calibration.camera;
    recording->camera->width_px = size.width_px, recording->camera->height_px = size.height_px;
    recording->T_cam_lidar = calibration.T_cam_lidar;
    recording->notes.push_back("calibration: " + path + ", camera " + std::to_string(camera));
  } catch (const InputError& error) {
    recording->warnings.push_back(std::string(error.what()) +
                                  ": not KITTI's odometry format, the calibration is left out");
  }
}

}  // namespace tvl
