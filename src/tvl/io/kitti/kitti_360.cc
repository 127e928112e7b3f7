#include "tvl/io/kitti/kitti_360.h"

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/cloud/file_names.h"
#include "tvl/io/cloud/file_streams.h"
#include "tvl/io/kitti_times.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

struct Drive {
  fs::path root;
  std::string name;
  fs::path velodyne;  // velodyne_points
};

bool HasScans(const fs::path& drive) {
  std::error_code ignored;
  return fs::is_directory(drive / "velodyne_points", ignored);
}

// Drives of a root that have scans, sorted.
std::vector<std::string> DrivesOf(const fs::path& root) {
  std::vector<std::string> drives;
  std::error_code error;
  fs::directory_iterator it(root / "data_3d_raw", error), end;
  for (; !error && it != end; it.increment(error)) {
    if (HasScans(it->path())) drives.push_back(it->path().filename().string());
  }
  std::sort(drives.begin(), drives.end());
  return drives;
}

// The root if `path` is ROOT/data_3d_raw/DRIVE, else empty.
fs::path RootOfDrive(const std::string& path) {
  fs::path full = fs::absolute(path).lexically_normal();
  if (!full.has_filename()) full = full.parent_path();
  const bool is_drive =
      full.parent_path().filename() == "data_3d_raw" && fs::is_directory(full / "velodyne_points");
  return is_drive ? full.parent_path().parent_path() : fs::path();
}

Drive FindDrive(const std::string& path) {
  const fs::path root = RootOfDrive(path);
  if (!root.empty()) return {root, NameOfFolder(path), fs::path(path) / "velodyne_points"};
  const std::vector<std::string> drives = DrivesOf(path);
  TVL_CHECK_INPUT(!drives.empty())
      << path << ": no data_3d_raw/DRIVE/velodyne_points (KITTI-360 layout)";
  std::string names;
  for (const std::string& drive : drives) names += " " + drive;
  TVL_CHECK_INPUT(drives.size() == 1)
      << path << ": several drives, name " << path << "/data_3d_raw/DRIVE with one of" << names;
  return {path, drives[0], fs::path(path) / "data_3d_raw" / drives[0] / "velodyne_points"};
}

// The rows of a matrix of three rows from numbers in row-major order.
Matrix34d MatrixOf(const std::vector<double>& numbers, int columns) {
  Matrix34d m = Matrix34d::Zero();
  for (int i = 0; i < 3 * columns; ++i) {
    m(i / columns, i % columns) = numbers[static_cast<size_t>(i)];
  }
  return m;
}

Rigid3d ReadCamToVelo(const std::string& path) {
  const std::vector<std::string> lines = ReadLines(path);
  TVL_CHECK_INPUT(lines.size() == 1) << path << ": want one line, has " << lines.size();
  const std::vector<double> numbers = ParseNumbers(lines[0], LineOf(path, 0));
  TVL_CHECK_INPUT(numbers.size() == 12)
      << LineOf(path, 0) << ": want 12 numbers, has " << numbers.size();
  return RigidOfMatrix(MatrixOf(numbers, 4), path);
}

// One line of stamps a file number.
std::vector<Timestamp> StampsByNumber(const fs::path& path, const std::vector<std::string>& files) {
  const std::vector<Timestamp> all = ReadRawTimestamps(path.string());
  std::vector<Timestamp> stamps;
  for (const std::string& file : files) {
    const std::optional<int64_t> number = FrameNumberOf(file);
    TVL_CHECK_INPUT(number && *number < static_cast<int64_t>(all.size()))
        << path.string() << ": has " << all.size() << " lines, none for " << file;
    stamps.push_back(all[static_cast<size_t>(*number)]);
  }
  return stamps;
}

void AddScans(const Drive& drive, Recording* recording) {
  const fs::path folder = drive.velodyne / "data";
  const std::vector<std::string> scans = ListFiles(folder, {".bin"});
  TVL_CHECK_INPUT(!scans.empty()) << folder.string() << ": no scans (NNNNNNNNNN.bin)";
  const BinLayout layout = KittiBinLayout();
  recording->scans =
      MakeFileScanStream(scans, StampsByNumber(drive.velodyne / "timestamps.txt", scans),
                         [layout](const std::string& scan) { return ReadBinScan(scan, layout); });
  recording->notes.push_back("scans: " + std::to_string(scans.size()) + " files in " +
                             folder.string() + " (KITTI-360 layout)");
}

void AddImages(const Drive& drive, const KittiCalibration& kitti, Recording* recording) {
  for (int camera = 0; camera < 2; ++camera) {
    const fs::path folder =
        drive.root / "data_2d_raw" / drive.name / ("image_0" + std::to_string(camera));
    const std::vector<std::string> images =
        ListFiles(folder / "data_rect", {".png", ".jpg", ".jpeg"});
    if (images.empty()) continue;
    const ImageSize size = SizeOfFirstImage(images);
    recording->images =
        MakeFileImageStream(images, StampsByNumber(folder / "timestamps.txt", images), size);
    const Calibration calibration = CalibrationOfCamera(kitti, camera);
    recording->camera = calibration.camera;
    recording->camera->width_px = size.width_px, recording->camera->height_px = size.height_px;
    recording->T_cam_lidar = calibration.T_cam_lidar;
    recording->notes.push_back("images: " + std::to_string(images.size()) + " in " +
                               (folder / "data_rect").string());
    return;
  }
  recording->T_cam_lidar = CalibrationWithoutCamera(kitti).T_cam_lidar;
  recording->warnings.push_back((drive.root / "data_2d_raw" / drive.name).string() +
                                ": no rectified images (image_00/data_rect): lidar only");
}

}  // namespace

Kitti360Calibration ReadKitti360Calibration(const std::string& calibration_folder) {
  const fs::path folder(calibration_folder);
  const KeyedNumbers perspective((folder / "perspective.txt").string());
  const Rigid3d T_velo_cam0 = ReadCamToVelo((folder / "calib_cam_to_velo.txt").string());
  Kitti360Calibration calibration;
  KittiCalibration& kitti = calibration.kitti;
  kitti.source = perspective.path();
  for (size_t n = 0; n < 2; ++n) {
    const std::string key = "P_rect_0" + std::to_string(n);
    if (perspective.Has(key)) kitti.P[n] = MatrixOf(perspective.Get(key, 12), 4);
  }
  kitti.rectification = RigidOfMatrix(MatrixOf(perspective.Get("R_rect_00", 9), 3),
                                      perspective.path() + ": R_rect_00");
  kitti.T_cam0_lidar = kitti.rectification * T_velo_cam0.Inverse();
  const std::string to_pose = (folder / "calib_cam_to_pose.txt").string();
  if (!fs::exists(to_pose)) return calibration;
  const KeyedNumbers poses(to_pose);
  for (size_t n = 0; n < 2; ++n) {
    const std::string key = "image_0" + std::to_string(n);
    if (!poses.Has(key)) continue;
    calibration.T_pose_cam[n] =
        RigidOfMatrix(MatrixOf(poses.Get(key, 12), 4), to_pose + ": " + key);
  }
  return calibration;
}

bool LooksLikeKitti360(const std::string& path) {
  return !RootOfDrive(path).empty() || !DrivesOf(path).empty();
}

Recording OpenKitti360(const std::string& path) {
  const Drive drive = FindDrive(path);
  Recording recording;
  recording.name = drive.name;
  AddScans(drive, &recording);
  const std::string folder = (drive.root / "calibration").string();
  const Kitti360Calibration calibration = ReadKitti360Calibration(folder);
  AddImages(drive, calibration.kitti, &recording);
  recording.notes.push_back("calibration: " + folder + ", R_rect_00 applied");
  return recording;
}

}  // namespace tvl
