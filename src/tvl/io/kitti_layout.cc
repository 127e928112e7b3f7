#include "tvl/io/kitti_layout.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>

#include "tvl/base/check.h"
#include "tvl/io/kitti_times.h"
#include "tvl/io/text_file.h"
#include "tvl/io/trajectory_io.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

constexpr double kDefaultPeriod_s = 0.1;  // KITTI's rate, where there are no stamps

using NumberedFiles = std::map<int64_t, std::string>;

// Files NNNN.ext by number; empty if there is no such folder.
NumberedFiles FindNumbered(const fs::path& folder, const std::vector<std::string>& extensions) {
  NumberedFiles files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string stem = entry.path().stem().string();
    const bool is_number = !stem.empty() && stem.size() <= 18 &&
                           stem.find_first_not_of("0123456789") == std::string::npos;
    const std::string extension = entry.path().extension().string();
    if (!is_number || std::count(extensions.begin(), extensions.end(), extension) == 0) continue;
    // Of 7.jpg and 7.png the later name wins, whatever the order of the folder.
    std::string& path = files[std::stoll(stem)];
    path = std::max(path, entry.path().string());
  }
  return files;
}

fs::path ScanFolder(const KittiLayout& layout) {
  const fs::path root(layout.folder);
  return layout.is_raw ? root / "velodyne_points" / "data" : root / "velodyne";
}

fs::path ImageFolder(const KittiLayout& layout, int camera) {
  const fs::path root(layout.folder);
  const std::string n = std::to_string(camera);
  return layout.is_raw ? root / ("image_0" + n) / "data" : root / ("image_" + n);
}

NumberedFiles FindImages(const KittiLayout& layout, int camera) {
  return FindNumbered(ImageFolder(layout, camera), {".png", ".jpg", ".jpeg"});
}

// The lowest camera with images, or the one asked for, checked; -1 for none.
int ChooseCamera(const KittiLayout& layout, int wanted) {
  TVL_CHECK_INPUT(wanted >= -1 && wanted <= 3) << "camera: must be 0..3, is " << wanted;
  if (wanted >= 0) {
    TVL_CHECK_INPUT(!FindImages(layout, wanted).empty())
        << ImageFolder(layout, wanted).string() << ": no images of camera " << wanted;
    return wanted;
  }
  for (int camera = 0; camera < 4; ++camera) {
    if (!FindImages(layout, camera).empty()) return camera;
  }
  return -1;
}

std::vector<KittiFrameFiles> PairByNumber(const KittiLayout& layout, const NumberedFiles& scans,
                                          const NumberedFiles& images) {
  const int64_t first = scans.begin()->first, last = scans.rbegin()->first;
  const auto span = static_cast<size_t>(last - first) + 1;
  TVL_CHECK_INPUT(span <= 10 * scans.size() + 100)
      << ScanFolder(layout).string() << ": " << scans.size() << " scans are numbered from " << first
      << " to " << last << ": most are missing";
  std::vector<KittiFrameFiles> frames(span);
  for (size_t i = 0; i < span; ++i) {
    frames[i].number = first + static_cast<int64_t>(i);
    const auto scan = scans.find(frames[i].number), image = images.find(frames[i].number);
    if (scan != scans.end()) frames[i].scan_path = scan->second;
    if (image != images.end()) frames[i].image_path = image->second;
  }
  return frames;
}

// Which entry of a file with `lines` lines belongs to frames[i]: by file number in a full file, by
// position in one that was cut together with the frames.
size_t FirstLine(const std::string& path, const std::vector<KittiFrameFiles>& frames,
                 size_t lines) {
  if (lines == frames.size()) return 0;
  TVL_CHECK_INPUT(lines > static_cast<size_t>(frames.back().number))
      << path << ": has " << lines << " lines for " << frames.size() << " frames numbered "
      << frames.front().number << " to " << frames.back().number;
  return static_cast<size_t>(frames.front().number);
}

std::string TimesPath(const KittiLayout& layout) {
  const fs::path root(layout.folder);
  if (!layout.is_raw) return (root / "times.txt").string();
  const fs::path image_times = ImageFolder(layout, std::max(layout.camera, 0)).parent_path();
  if (layout.camera >= 0 && fs::exists(image_times / "timestamps.txt")) {
    return (image_times / "timestamps.txt").string();
  }
  return (root / "velodyne_points" / "timestamps.txt").string();
}

KittiLayout WithStamps(KittiLayout layout) {
  const std::string path = TimesPath(layout);
  if (!fs::exists(path)) {
    layout.warnings.push_back(path + ": not there, 10 frames a second assumed");
    for (size_t i = 0; i < layout.frames.size(); ++i) {
      layout.frames[i].stamp = Timestamp::FromSeconds(kDefaultPeriod_s * static_cast<double>(i));
    }
    return layout;
  }
  const std::vector<Timestamp> stamps =
      layout.is_raw ? ReadRawTimestamps(path) : ReadOdometryTimes(path);
  const size_t first = FirstLine(path, layout.frames, stamps.size());
  for (size_t i = 0; i < layout.frames.size(); ++i) layout.frames[i].stamp = stamps[first + i];
  return layout;
}

KittiLayout WithTruth(KittiLayout layout) {
  const std::string path = (fs::path(layout.folder) / "poses.txt").string();
  if (layout.is_raw || !fs::exists(path)) return layout;
  const std::vector<Rigid3d> poses = ReadKittiPoses(path);
  const size_t first = FirstLine(path, layout.frames, poses.size());
  const Rigid3d T_first_origin = poses[first].Inverse();
  for (size_t i = 0; i < layout.frames.size(); ++i) {
    layout.truth_T_first_cam0.push_back(T_first_origin * poses[first + i]);
  }
  return layout;
}

std::optional<Deskew> ReadDeskew(const std::string& path) {
  if (!fs::exists(path)) return std::nullopt;
  std::optional<Deskew> deskew;
  try {
    const YAML::Node root = YAML::LoadFile(path);
    TVL_CHECK_INPUT(root.IsMap()) << path << ": want the key `deskew`";
    for (const auto& entry : root) {
      const auto key = entry.first.as<std::string>(), value = entry.second.as<std::string>();
      const std::string where =
          LineOf(path, static_cast<size_t>(std::max(entry.first.Mark().line, 0))) + ": " + key;
      TVL_CHECK_INPUT(key == "deskew") << where << ": unknown key";
      TVL_CHECK_INPUT(value == "none" || value == "cw" || value == "ccw")
          << where << ": must be none, cw or ccw, is " << value;
      deskew = value == "none" ? Deskew::kNone
               : value == "cw" ? Deskew::kClockwise
                               : Deskew::kCounterClockwise;
    }
  } catch (const YAML::Exception& e) {
    throw InputError(path + ": " + e.what());
  }
  return deskew;
}

KittiLayout WithFrames(KittiLayout layout, int camera) {
  const NumberedFiles scans = FindNumbered(ScanFolder(layout), {".bin"});
  TVL_CHECK_INPUT(!scans.empty()) << ScanFolder(layout).string() << ": no scans (NNNNNN.bin)";
  layout.camera = ChooseCamera(layout, camera);
  const NumberedFiles images =
      layout.camera >= 0 ? FindImages(layout, layout.camera) : NumberedFiles();
  layout.frames = PairByNumber(layout, scans, images);
  layout.missing_scans = layout.frames.size() - scans.size();
  for (const KittiFrameFiles& frame : layout.frames) {
    if (layout.camera >= 0 && frame.image_path.empty()) ++layout.missing_images;
  }
  return layout;
}

KittiLayout WithWarnings(KittiLayout layout) {
  const auto warn = [&](const std::string& text) { layout.warnings.push_back(text); };
  const std::string frames = std::to_string(layout.frames.size()) + " frames";
  if (layout.camera < 0) warn(layout.folder + ": no images: lidar only");
  if (layout.missing_scans > 0) {
    warn(layout.folder + ": " + std::to_string(layout.missing_scans) + " scans of " + frames +
         " are missing");
  }
  if (layout.missing_images > 0) {
    warn(layout.folder + ": " + std::to_string(layout.missing_images) + " images of " + frames +
         " are missing");
  }
  return layout;
}

}  // namespace

bool LooksLikeKitti(const std::string& folder) {
  std::error_code ignored;
  const fs::path root = fs::path(folder).lexically_normal();
  if (fs::is_directory(root / "velodyne", ignored)) return fs::exists(root / "calib.txt", ignored);
  const fs::path named = root.has_filename() ? root : root.parent_path();
  return fs::is_directory(root / "velodyne_points" / "data", ignored) &&
         fs::exists(named.parent_path() / "calib_velo_to_cam.txt", ignored);
}

KittiLayout FindKittiLayout(const std::string& folder, int camera) {
  TVL_CHECK_INPUT(fs::is_directory(folder)) << folder << ": no such folder";
  KittiLayout layout;
  layout.folder = folder;
  const fs::path full = fs::absolute(folder).lexically_normal();
  layout.name = (full.has_filename() ? full : full.parent_path()).filename().string();
  layout.is_raw = fs::is_directory(fs::path(folder) / "velodyne_points");
  TVL_CHECK_INPUT(layout.is_raw || fs::is_directory(fs::path(folder) / "velodyne"))
      << folder << ": neither velodyne/ (KITTI odometry layout) nor velodyne_points/ (KITTI raw)";
  const fs::path root = layout.is_raw ? full / ".." : fs::path(folder);
  layout.calibration = layout.is_raw ? ReadRawCalibration(root.lexically_normal().string())
                                     : ReadOdometryCalibration((root / "calib.txt").string());
  layout = WithWarnings(WithTruth(WithStamps(WithFrames(std::move(layout), camera))));
  layout.deskew = ReadDeskew((fs::path(folder) / "tvl.yaml").string());
  return layout;
}

}  // namespace tvl
