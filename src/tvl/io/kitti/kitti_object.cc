#include "tvl/io/kitti/kitti_object.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/cloud/file_names.h"
#include "tvl/io/cloud/file_streams.h"
#include "tvl/io/cloud/image_folder.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

// Entries of two calibrations that differ by more than printed digits explain.
constexpr double kSameEntries = 1e-6;

bool HasLayout(const fs::path& folder) {
  std::error_code ignored;
  return fs::is_directory(folder / "velodyne", ignored) &&
         fs::is_directory(folder / "calib", ignored);
}

// The folder with velodyne/ and calib/; empty: none.
fs::path FrameFolder(const std::string& path) {
  for (const fs::path& folder :
       {fs::path(path), fs::path(path) / "training", fs::path(path) / "testing"}) {
    if (HasLayout(folder)) return folder;
  }
  return {};
}

// What is used of a calibration, to be compared.
bool IsSame(const KittiCalibration& a, const KittiCalibration& b, size_t camera) {
  if ((a.T_cam0_lidar.Matrix() - b.T_cam0_lidar.Matrix()).cwiseAbs().maxCoeff() > kSameEntries) {
    return false;
  }
  if (!a.P[camera] || !b.P[camera]) return a.P[camera].has_value() == b.P[camera].has_value();
  return (*a.P[camera] - *b.P[camera]).cwiseAbs().maxCoeff() <= kSameEntries;
}

// Files whose calibration cannot be read differ too.
size_t CountOthers(const std::vector<std::string>& paths, const KittiCalibration& first,
                   size_t camera) {
  size_t others = 0;
  for (const std::string& path : paths) {
    try {
      others += IsSame(first, ReadObjectCalibration(path), camera) ? 0 : 1;
    } catch (const InputError&) {
      ++others;
    }
  }
  return others;
}

// The calibration files of these scans that are there.
std::vector<std::string> CalibrationsOf(const fs::path& folder,
                                        const std::vector<std::string>& scans) {
  std::vector<std::string> paths;
  for (const std::string& scan : scans) {
    const std::string path = (folder / "calib" / (StemOf(scan) + ".txt")).string();
    if (fs::is_regular_file(path)) paths.push_back(path);
  }
  return paths;
}

void AddObjectCalibration(const fs::path& folder, const std::vector<std::string>& scans, int camera,
                          Recording* recording) {
  const std::vector<std::string> paths = CalibrationsOf(folder, scans);
  TVL_CHECK_INPUT(!paths.empty()) << (folder / "calib").string()
                                  << ": no calibration of any scan (NNNNNN.txt)";
  const KittiCalibration first = ReadObjectCalibration(paths[0]);
  const size_t others = CountOthers(paths, first, static_cast<size_t>(std::max(camera, 0)));
  if (others > 0 || paths.size() < scans.size()) {
    recording->warnings.push_back((folder / "calib").string() + ": " + std::to_string(others) +
                                  " frames have another calibration and " +
                                  std::to_string(scans.size() - paths.size()) +
                                  " have none: all are taken with that of " + paths[0]);
  }
  recording->notes.push_back("calibration: " + paths[0] + ", R0_rect applied");
  if (recording->images == nullptr) {
    recording->T_cam_lidar = CalibrationWithoutCamera(first).T_cam_lidar;
    return;
  }
  const Calibration calibration = CalibrationOfCamera(first, camera);
  recording->camera = calibration.camera;
  recording->T_cam_lidar = calibration.T_cam_lidar;
}

}  // namespace

KittiCalibration ReadObjectCalibration(const std::string& path) {
  // Tr_velo_to_cam and P0..P3 are written as in the odometry files.
  KittiCalibration kitti = ReadOdometryCalibration(path);
  const std::vector<double> R = KeyedNumbers(path).Get("R0_rect", 9);
  Matrix34d m = Matrix34d::Zero();
  for (int i = 0; i < 9; ++i) m(i / 3, i % 3) = R[static_cast<size_t>(i)];
  kitti.rectification = RigidOfMatrix(m, path + ": R0_rect");
  kitti.T_cam0_lidar = kitti.rectification * kitti.T_cam0_lidar;
  return kitti;
}

bool LooksLikeKittiObject(const std::string& path) { return !FrameFolder(path).empty(); }

Recording OpenKittiObject(const std::string& path) {
  const fs::path folder = FrameFolder(path);
  TVL_CHECK_INPUT(!folder.empty())
      << path << ": no velodyne/ and calib/, here or in training/ (KITTI object layout)";
  const std::vector<std::string> scans = ListFiles(folder / "velodyne", {".bin"});
  TVL_CHECK_INPUT(!scans.empty()) << (folder / "velodyne").string() << ": no scans (NNNNNN.bin)";
  Recording recording;
  recording.name = NameOfFolder(path);
  recording.notes.push_back("scans: " + std::to_string(scans.size()) + " files in " +
                            (folder / "velodyne").string() + " (KITTI object layout)");
  const std::string images = FindImageFolder(folder.string());
  const int camera = images.empty() ? -1 : CameraNumberOf(images);
  if (camera >= 0) AddImages(folder.string(), images, scans, {}, &recording);
  AddObjectCalibration(folder, scans, camera, &recording);
  if (recording.camera) {
    const ImageSize size = SizeOfFirstImage(ListFiles(images, {".png", ".jpg", ".jpeg"}));
    recording.camera->width_px = size.width_px, recording.camera->height_px = size.height_px;
  }
  const BinLayout layout = KittiBinLayout();
  recording.scans = MakeFileScanStream(
      scans, {}, [layout](const std::string& scan) { return ReadBinScan(scan, layout); });
  return recording;
}

}  // namespace tvl
