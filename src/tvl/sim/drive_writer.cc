#include "tvl/sim/drive_writer.h"

#include <cstdio>
#include <filesystem>
#include <iomanip>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <ostream>

#include "tvl/base/check.h"
#include "tvl/base/parallel.h"
#include "tvl/base/units.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/io/velodyne_bin.h"

namespace tvl::sim {
namespace {

namespace fs = std::filesystem;

std::string Numbered(const fs::path& folder, size_t index, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06zu%s", index, extension);
  return (folder / name).string();
}

void WriteFrame(const SensorFrame& frame, const fs::path& folder) {
  const auto index = static_cast<size_t>(frame.id);
  WriteVelodyneBin(Numbered(folder / "velodyne", index, ".bin"), *frame.scan);
  if (frame.image.empty()) return;
  const std::string path = Numbered(folder / "image_0", index, ".png");
  WriteAtomicallyByName(path, [&](const std::string& name) {
    // Little compression: noise does not compress, and speed matters here.
    TVL_CHECK_INPUT(cv::imwrite(name, frame.image, {cv::IMWRITE_PNG_COMPRESSION, 1}))
        << path << ": cannot be written";
  });
}

void WriteMatrix(std::ostream& out, const char* key, const Matrix34d& m) {
  out << key << ":";
  for (int i = 0; i < 12; ++i) out << " " << m(i / 4, i % 4);
  out << "\n";
}

void WriteCalibration(const Calibration& c, const fs::path& path) {
  Matrix34d P = Matrix34d::Zero();
  P(0, 0) = c.camera.fx_px, P(1, 1) = c.camera.fy_px;
  P(0, 2) = c.camera.cx_px, P(1, 2) = c.camera.cy_px, P(2, 2) = 1.0;
  WriteAtomically(path.string(), [&](std::ostream& out) {
    out << std::scientific << std::setprecision(12);
    for (const char* key : {"P0", "P1", "P2", "P3"}) WriteMatrix(out, key, P);
    WriteMatrix(out, "Tr", c.T_cam0_lidar.Matrix());
  });
}

const char* SpinName(Deskew spin) {
  if (spin == Deskew::kNone) return "none";
  return spin == Deskew::kClockwise ? "cw" : "ccw";
}

std::string RangeText(const FrameRange& range) {
  return range.IsEmpty() ? "" : std::to_string(range.begin) + ":" + std::to_string(range.end);
}

void WriteMeta(const SimDataset& drive, const fs::path& path) {
  const SimOptions& o = drive.options();
  const nlohmann::ordered_json meta = {
      {"simulated", true},
      {"preset", o.preset},
      {"trajectory", fs::path(o.trajectory_file).filename().string()},
      {"seed", o.seed},
      {"frames", drive.size()},
      {"length_m", drive.Length_m()},
      {"raw", SpinName(o.raw)},
      {"beams", o.beams},
      {"beam_errors", o.beam_errors},
      {"beam_error_shape", o.beam_error_shape == BeamErrorShape::kSine ? "sine" : "independent"},
      {"speed_m_s", o.speed_m_s},
      {"turn", o.is_turning},
      {"faster", o.faster},
      {"clean", o.clean},
      {"camera", o.has_camera},
      {"camera_delay_ms", o.camera_delay_ms},
      {"changes", o.changes},
      {"lateral_m", o.lateral_m},
      {"tunnel_frames", RangeText(o.tunnel)},
      {"open_frames", RangeText(o.open)},
      {"night_frames", RangeText(drive.drive().night)},
      {"vertical_correction_rad", drive.setup().lidar.vertical_correction_rad},
  };
  WriteAtomically(path.string(), [&](std::ostream& out) { out << meta.dump(2) << "\n"; });
}

// For --profile: a folder is else taken for one of an HDL-64E.
void WriteLidarProfile(const LidarModel& lidar, const fs::path& path) {
  WriteAtomically(path.string(), [&](std::ostream& out) {
    out << "lidar:\n  name: " << lidar.name << "\n  beam_elevation_deg: [";
    for (int i = 0; i < lidar.rows(); ++i) {
      out << (i == 0 ? "" : ", ") << RadToDeg(lidar.beam_elevation_rad[static_cast<size_t>(i)]);
    }
    out << "]\n  columns: " << lidar.columns << "\n  sweep_s: " << lidar.sweep_s
        << "\n  range_sigma_m: " << lidar.range_sigma_m << "\n  min_range_m: " << lidar.min_range_m
        << "\n  max_range_m: " << lidar.max_range_m << "\n";
  });
}

void WriteTimes(const SimDataset& drive, const fs::path& path) {
  WriteAtomically(path.string(), [&](std::ostream& out) {
    out << std::scientific << std::setprecision(6);
    for (size_t i = 0; i < drive.size(); ++i) {
      out << static_cast<double>(i) * kFrameInterval_s << "\n";
    }
  });
}

}  // namespace

void WriteDrive(const SimDataset& drive, const std::string& folder, int threads,
                const std::function<void(size_t)>& progress) {
  const fs::path root(folder);
  const Executor executor(threads);
  std::mutex mutex;
  size_t done = 0;
  executor.For(drive.size(), 1, [&](size_t index, size_t) {
    WriteFrame(drive.Frame(index), root);
    const std::lock_guard<std::mutex> lock(mutex);
    progress(++done);
  });
  WriteCalibration(drive.setup().calibration, root / "calib.txt");
  WriteTimes(drive, root / "times.txt");
  if (drive.options().beams != 64) {
    WriteLidarProfile(drive.setup().lidar, root / "lidar.yaml");
  }
  WriteKittiPoses((root / "poses.txt").string(), drive.Truth_T_first_cam0());
  WriteMeta(drive, root / "meta.json");
}

}  // namespace tvl::sim
