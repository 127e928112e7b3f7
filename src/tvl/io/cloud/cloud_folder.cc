#include "tvl/io/cloud/cloud_folder.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/io/cloud/file_names.h"
#include "tvl/io/cloud/file_streams.h"
#include "tvl/io/cloud/image_folder.h"
#include "tvl/io/cloud/stamps.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string>& CloudExtensions() {
  // LAZ is not read, but a folder of it is recognised, so that the refusal can say what to do.
  static const std::vector<std::string> extensions = {".bin", ".pcd", ".ply", ".las", ".laz"};
  return extensions;
}

std::vector<std::string> CloudsIn(const fs::path& folder) {
  return ListFiles(folder, CloudExtensions());
}

std::vector<fs::path> SubFolders(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (it->is_directory(ignored)) folders.push_back(it->path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

// Sub folders that hold scans, themselves or in `data`: the first of a usual name, else all.
std::vector<fs::path> FoldersOfScans(const fs::path& root) {
  for (const char* name : {"velodyne",
                           "velodyne_points/data",
                           "velodyne_points",
                           "lidar",
                           "lidar/data",
                           "points",
                           "points/data",
                           "scans",
                           "clouds",
                           "pointcloud",
                           "pointclouds",
                           "point_cloud",
                           "point_clouds",
                           "os1_cloud_node",
                           "os_cloud_node",
                           "ouster",
                           "ouster_points",
                           "livox",
                           "livox_points",
                           "hesai",
                           "LIDAR_TOP",
                           "sweeps",
                           "pcd",
                           "bin",
                           "ply",
                           "las"}) {
    if (!CloudsIn(root / name).empty()) return {root / name};
  }
  std::vector<fs::path> found;
  for (const fs::path& folder : SubFolders(root)) {
    if (!CloudsIn(folder).empty()) {
      found.push_back(folder);
    } else if (!CloudsIn(folder / "data").empty()) {
      found.push_back(folder / "data");
    }
  }
  return found;
}

// "a/b/" as "a/b", so that paths can be compared.
std::string WithoutSlash(const std::string& path) {
  const fs::path normal = fs::path(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

struct ScanFiles {
  std::string root;    // of the recording
  std::string folder;  // of the scans
  std::vector<std::string> paths;
};

// Of several kinds of files the most frequent is meant; the others are named.
void KeepOneKind(ScanFiles* files, Recording* recording) {
  std::map<std::string, std::vector<std::string>> by_extension;
  for (const std::string& path : files->paths) {
    by_extension[fs::path(path).extension().string()].push_back(path);
  }
  const auto most = std::max_element(
      by_extension.begin(), by_extension.end(),
      [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
  for (const auto& [extension, paths] : by_extension) {
    if (extension == most->first) continue;
    recording->warnings.push_back(files->folder + ": " + std::to_string(paths.size()) + " " +
                                  extension + " files are left out, most scans are " + most->first);
  }
  files->paths = most->second;
}

ScanFiles FindScans(const std::string& path) {
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) {
    const fs::path parent = fs::path(path).parent_path();
    const std::string folder = parent.empty() ? "." : parent.string();
    return {folder, folder, {path}};
  }
  TVL_CHECK_INPUT(fs::is_directory(path, ignored)) << path << ": no such file or folder";
  const std::vector<fs::path> folders = FoldersOfScans(path);
  std::vector<std::string> own = CloudsIn(path);
  // A map that was written beside the folder of scans is not the recording.
  const bool is_own = folders.empty() || own.size() > CloudsIn(folders[0]).size();
  if (!own.empty() && is_own) return {path, path, std::move(own)};
  TVL_CHECK_INPUT(!folders.empty())
      << path << ": no scans (.bin, .pcd, .ply, .las), neither here nor in a sub folder";
  std::string names;
  for (const fs::path& folder : folders) names += " " + folder.filename().string();
  TVL_CHECK_INPUT(folders.size() == 1)
      << path << ": several sub folders hold scans, name the one that is meant:" << names;
  return {path, folders[0].string(), CloudsIn(folders[0])};
}

// Files that may hold the stamps of the scans, the likelier first. Tables outside of the recording
// are none of its own.
std::vector<std::string> StampFiles(const ScanFiles& files) {
  const fs::path folder = files.folder;
  std::vector<fs::path> places = {folder, folder.parent_path()};
  if (folder.parent_path() != files.root && folder != files.root) places.emplace_back(files.root);
  std::vector<std::string> found;
  for (const fs::path& place : places) {
    for (const char* name : {"times.txt", "timestamps.txt", "timestamp.txt", "time.txt",
                             "stamps.txt", "timestamps_lidar.txt", "lidar_timestamps.txt"}) {
      if (fs::is_regular_file(place / name)) found.push_back((place / name).string());
    }
    if (place != folder && files.folder == files.root) continue;
    for (const std::string& csv : ListFiles(place, {".csv"})) found.push_back(csv);
  }
  return found;
}

void SortByStamp(std::vector<std::string>* paths, std::vector<Timestamp>* stamps) {
  std::vector<size_t> order(paths->size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return (*stamps)[a] < (*stamps)[b]; });
  std::vector<std::string> sorted_paths;
  std::vector<Timestamp> sorted_stamps;
  for (const size_t i : order) {
    sorted_paths.push_back((*paths)[i]);
    sorted_stamps.push_back((*stamps)[i]);
  }
  *paths = std::move(sorted_paths), *stamps = std::move(sorted_stamps);
}

// Sorts the files by stamps that come from their names: fractions of different lengths come in
// another order by name than by time. Stamps of a text file stay with the order of the names.
StampsRead FindStamps(ScanFiles* files, Recording* recording) {
  for (const std::string& path : StampFiles(*files)) {
    StampsRead read = StampsFromFile(path, files->paths);
    if (!read.stamps.empty()) {
      auto& list = read.is_doubtful ? recording->warnings : recording->notes;
      list.push_back("stamps: " + path + ": " + read.what);
      return read;
    }
    // Any table may lie there, but a text file of that name should have been understood.
    auto& list = fs::path(path).extension() == ".txt" ? recording->warnings : recording->notes;
    list.push_back(path + ": no stamps of the scans: " + read.what);
  }
  StampsRead read = StampsFromNames(files->paths);
  auto& list = read.is_doubtful ? recording->warnings : recording->notes;
  list.push_back((read.stamps.empty() ? "stamps: none: " : "stamps: file names: ") + read.what);
  if (!read.stamps.empty()) SortByStamp(&files->paths, &read.stamps);
  return read;
}

}  // namespace

bool LooksLikeCloudFolder(const std::string& path) {
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) {
    const std::vector<std::string>& extensions = CloudExtensions();
    return std::count(extensions.begin(), extensions.end(), ExtensionOf(path)) > 0;
  }
  return fs::is_directory(path, ignored) &&
         (!CloudsIn(path).empty() || FoldersOfScans(path).size() == 1);
}

Recording OpenCloudFolder(const std::string& path) {
  ScanFiles files = FindScans(WithoutSlash(path));
  Recording recording;
  recording.name = NameOfFolder(path);
  KeepOneKind(&files, &recording);
  const bool is_bin = ExtensionOf(files.paths[0]) == ".bin";
  const BinLayout bin = is_bin ? RecogniseBinFiles(files.paths) : BinLayout();
  const ReadScanFile read = ReaderOf(files.paths[0], bin);
  recording.notes.push_back("scans: " + std::to_string(files.paths.size()) + " files in " +
                            files.folder + (is_bin ? ", " + bin.note : ""));
  for (const std::string& note : DescribeScans(files.paths, read)) recording.notes.push_back(note);
  const StampsRead stamps = FindStamps(&files, &recording);
  const bool is_folder = fs::is_directory(path);
  const std::string images = is_folder ? FindImageFolder(files.root) : std::string();
  if (!images.empty()) AddImages(files.root, images, files.paths, stamps, &recording);
  if (is_folder) AddCalibration(files.root, images, &recording);
  recording.scans = MakeFileScanStream(files.paths, stamps.stamps, read);
  return recording;
}

}  // namespace tvl
