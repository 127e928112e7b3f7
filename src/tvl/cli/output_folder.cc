#include "tvl/cli/output_folder.h"

#include <filesystem>
#include <fstream>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/io/atomic_file.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kResults[] = {"trajectory_kitti.txt",
                                    "trajectory_tum.txt",
                                    "odometry_kitti.txt",
                                    "truth_kitti.txt",
                                    "map.pcd",
                                    "map.ply",
                                    "map.png",
                                    "loops.csv",
                                    "graph.g2o",
                                    "loops.png",
                                    "run.json",
                                    "resolved.yaml"};

// loop_place_1.png, loop_place_2.png, ...
bool IsLoopPlace(const fs::path& file) {
  const std::string prefix = "loop_place_", stem = file.stem().string();
  return file.extension() == ".png" && stem.size() > prefix.size() && stem.rfind(prefix, 0) == 0 &&
         stem.find_first_not_of("0123456789", prefix.size()) == std::string::npos;
}

}  // namespace

void PrepareOutputFolder(const std::string& folder) {
  const std::string advice = "; choose another folder for the results (--out)";
  std::error_code error, ignored;
  fs::create_directories(folder, error);
  TVL_CHECK_INPUT(!error && fs::is_directory(folder, ignored))
      << folder << ": cannot be made: " << (error ? error.message() : "not a folder") << advice;
  for (const char* name : kResults) {
    TVL_CHECK_INPUT(!fs::is_directory(fs::path(folder) / name, ignored))
        << (fs::path(folder) / name).string() << ": a folder is in the way of this result"
        << advice;
  }
  const std::string trial = TemporaryNameFor((fs::path(folder) / "trial").string());
  std::ofstream file(trial);
  file << "tvl";
  file.close();
  const bool is_written = !file.fail();
  fs::remove(trial, ignored);
  TVL_CHECK_INPUT(is_written) << folder << ": cannot be written to" << advice;
}

void RemoveOldResults(const std::string& folder) {
  std::vector<fs::path> old;
  for (const char* name : kResults) old.push_back(fs::path(folder) / name);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (IsLoopPlace(entry.path())) old.push_back(entry.path());
  }
  for (const fs::path& path : old) {
    std::error_code error;
    fs::remove(path, error);
    TVL_CHECK_INPUT(!error) << path.string()
                            << ": of an earlier run, cannot be removed: " << error.message();
  }
}

}  // namespace tvl
