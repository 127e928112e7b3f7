#include "tvl/cli/inspect.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <thread>

#include "tvl/base/units.h"
#include "tvl/cli/commands.h"
#include "tvl/cli/input.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/rig.h"
#include "tvl/io/velodyne_bin.h"

namespace tvl {
namespace {

constexpr size_t kFaultsListed = 3;  // of a kind; the rest is counted

// What is kept of a frame when its points and pixels are gone.
struct FrameSummary {
  Timestamp stamp;
  bool has_scan = false;
  size_t points = 0, rings = 0;
  bool has_intensity = false, has_rings = false, has_time_offsets = false;
  std::string image_format;  // empty: no image
  std::vector<FrameFault> faults;
};

std::string FormatOf(const cv::Mat& image) {
  if (image.empty()) return "";
  return std::to_string(image.cols) + "x" + std::to_string(image.rows) +
         (image.depth() == CV_8U ? ", 8 bit" : ", 16 bit") +
         (image.channels() == 1 ? ", grey" : ", colour");
}

FrameSummary Summarise(SensorFrame frame) {
  FrameSummary summary;
  summary.stamp = frame.stamp;
  summary.image_format = FormatOf(frame.image);
  summary.faults = std::move(frame.faults);
  if (frame.scan == nullptr) return summary;
  const LidarScan& scan = *frame.scan;
  summary.has_scan = true;
  summary.points = scan.size();
  summary.rings = static_cast<size_t>(CountAzimuthTurns(scan.points));
  summary.has_intensity = !scan.intensity.empty();
  summary.has_rings = !scan.ring.empty();
  summary.has_time_offsets = !scan.time_offset_s.empty();
  return summary;
}

CountRange RangeOf(std::vector<size_t> counts) {
  if (counts.empty()) return {};
  std::sort(counts.begin(), counts.end());
  return {counts.front(), counts[counts.size() / 2], counts.back()};
}

InspectReport WithTimes(InspectReport report, const std::vector<FrameSummary>& frames) {
  std::vector<double> steps_s;
  for (size_t i = 1; i < frames.size(); ++i) {
    steps_s.push_back(SecondsBetween(frames[i - 1].stamp, frames[i].stamp));
  }
  if (steps_s.empty()) return report;
  report.duration_s = SecondsBetween(frames.front().stamp, frames.back().stamp);
  std::sort(steps_s.begin(), steps_s.end());
  const double median_s = steps_s[steps_s.size() / 2];
  report.rate_hz = median_s > 0.0 ? 1.0 / median_s : 0.0;
  report.longest_gap_s = steps_s.back();
  return report;
}

InspectReport WithSensors(InspectReport report, const std::vector<FrameSummary>& frames) {
  std::vector<size_t> points, rings;
  for (const FrameSummary& frame : frames) {
    if (!frame.image_format.empty()) ++report.images;
    if (report.image_format.empty()) report.image_format = frame.image_format;
    if (!frame.has_scan) continue;
    ++report.scans;
    points.push_back(frame.points);
    rings.push_back(frame.rings);
    report.has_intensity |= frame.has_intensity;
    report.has_rings |= frame.has_rings;
    report.has_time_offsets |= frame.has_time_offsets;
  }
  report.points = RangeOf(points);
  report.rings = RangeOf(rings);
  return report;
}

InspectReport WithFaults(InspectReport report, const std::vector<FrameSummary>& frames) {
  for (const FrameSummary& frame : frames) {
    for (const FrameFault& fault : frame.faults) {
      FaultSummary& summary = report.faults[ToString(fault.kind)];
      if (++summary.count <= kFaultsListed) summary.first.push_back(fault.message);
    }
  }
  return report;
}

InspectReport WithVerdict(InspectReport report, const std::vector<FrameSummary>& frames) {
  if (frames.empty()) {
    report.unusable_reason = "no frames";
  } else if (!frames.front().has_scan) {
    report.unusable_reason = "the first frame has no usable scan";
  } else if (2 * report.scans < report.frames) {
    report.unusable_reason = "most scans are unusable";
  }
  report.usable = report.unusable_reason.empty();
  return report;
}

void PrintSensors(const SensorSetup& setup, const InspectReport& report, std::ostream& out) {
  out << "  scans      " << report.scans << ", points " << report.points.min << " / "
      << report.points.median << " / " << report.points.max
      << " (min / median / max), azimuth turns " << report.rings.min << " / " << report.rings.median
      << " / " << report.rings.max << "\n"
      << "  points     " << (report.has_intensity ? "with" : "without") << " intensity, "
      << (report.has_rings ? "with" : "without") << " rings, "
      << (report.has_time_offsets ? "with" : "without") << " time offsets\n"
      << "  lidar      profile " << setup.lidar.name << ", ";
  if (setup.lidar.rows() > 0) {
    out << setup.lidar.rows() << " beams from " << RadToDeg(setup.lidar.beam_elevation_rad.front())
        << " to " << RadToDeg(setup.lidar.beam_elevation_rad.back()) << " deg";
  } else {
    out << "beams not known";
  }
  out << ", vertical correction " << RadToDeg(setup.lidar.vertical_correction_rad) << " deg\n"
      << "  images     ";
  if (setup.has_camera) {
    out << report.images << ", " << report.image_format << "\n";
  } else {
    out << "none: lidar only\n";
  }
}

void PrintCalibration(const SensorSetup& setup, std::ostream& out) {
  const Calibration& calibration = setup.calibration;
  const Camera& camera = calibration.camera;
  if (setup.has_camera) {
    out << "  camera     fx " << camera.fx_px << ", fy " << camera.fy_px << ", cx " << camera.cx_px
        << ", cy " << camera.cy_px << " px, " << (camera.IsDistorted() ? "distorted" : "rectified")
        << "\n";
  }
  // Where the camera sits, seen from the lidar: easier to judge than T_cam_lidar.
  const Rigid3d T_lidar_cam = calibration.T_cam_lidar.Inverse();
  const Eigen::Vector3d axis_lidar = T_lidar_cam.q() * Eigen::Vector3d::UnitZ();
  out << "  mounting   " << (setup.has_camera ? "camera" : "camera 0") << " at ["
      << T_lidar_cam.t().transpose() << "] m of the lidar, looking along ["
      << axis_lidar.transpose() << "]\n";
}

void PrintFaults(const SensorSetup& setup, const InspectReport& report, std::ostream& out) {
  for (const std::string& note : setup.notes) out << "  recognised " << note << "\n";
  for (const std::string& warning : setup.warnings) out << "  warning    " << warning << "\n";
  for (const auto& [kind, faults] : report.faults) {
    out << "  fault      " << kind << ": " << faults.count << "\n";
    for (const std::string& message : faults.first) out << "               " << message << "\n";
    if (faults.count > faults.first.size()) {
      out << "               and " << faults.count - faults.first.size() << " more\n";
    }
  }
  if (report.faults.empty()) out << "  faults     none\n";
}

std::string DeskewText(const SensorSetup& setup) {
  if (!setup.deskew) return "not stated";
  switch (*setup.deskew) {
    case Deskew::kNone:
      return "compensated to the image instant (stated)";
    case Deskew::kClockwise:
      return "raw, turning clockwise (stated)";
    case Deskew::kCounterClockwise:
      return "raw, turning counter-clockwise (stated)";
  }
  return "";
}

void WriteRig(const SensorSetup& setup, const InputOptions& options, const std::string& path) {
  Rig rig;
  rig.lidar = setup.lidar;
  if (setup.has_camera) rig.camera = setup.calibration.camera;
  if (setup.has_camera) rig.T_cam_lidar = setup.calibration.T_cam_lidar;
  rig.lidar_topic = options.lidar_topic;
  rig.image_topic = options.image_topic;
  WriteAtomically(path, [&](std::ostream& out) { out << DumpRig(rig); });
  std::cout << "rig written to " << path << "\n";
}

void RunInspect(const std::string& spec, InputOptions options, const std::string& rig) {
  options.require_first_scan = false;
  const auto dataset = OpenInput(spec, options);
  const Executor executor(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  const InspectReport report = Inspect(*dataset, executor);
  PrintReport(*dataset, report, std::cout);
  if (!rig.empty()) WriteRig(dataset->setup(), options, rig);
  if (!report.usable) throw CLI::RuntimeError(2);
}

}  // namespace

InspectReport Inspect(const Dataset& dataset, const Executor& executor) {
  std::vector<FrameSummary> frames(dataset.size());
  executor.For(frames.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) frames[i] = Summarise(dataset.Frame(i));
  });
  InspectReport report;
  report.frames = frames.size();
  const std::vector<Rigid3d> truth = dataset.Truth_T_first_cam0();
  for (size_t i = 1; i < truth.size(); ++i) {
    report.truth_length_m += (truth[i].t() - truth[i - 1].t()).norm();
  }
  report = WithFaults(WithSensors(WithTimes(std::move(report), frames), frames), frames);
  return WithVerdict(std::move(report), frames);
}

void PrintReport(const Dataset& dataset, const InspectReport& report, std::ostream& out) {
  const SensorSetup& setup = dataset.setup();
  const auto flags = out.flags();
  out << std::setprecision(6) << setup.name << "\n"
      << "  frames     " << report.frames << " in " << report.duration_s << " s, " << report.rate_hz
      << " a second, longest gap " << report.longest_gap_s << " s\n";
  PrintSensors(setup, report, out);
  out << std::setprecision(4);
  PrintCalibration(setup, out);
  out << "  motion     " << DeskewText(setup) << "\n"
      << "  truth      ";
  if (report.truth_length_m > 0.0) {
    out << report.truth_length_m << " m\n";
  } else {
    out << "none\n";
  }
  PrintFaults(setup, report, out);
  out << (report.usable ? "usable" : "not usable: " + report.unusable_reason) << "\n";
  out.flags(flags);
}

void AddInspectCommand(CLI::App& app) {
  auto* command = app.add_subcommand("inspect", "What an input holds, and what is wrong with it");
  struct Arguments {
    std::string input;
    InputOptions options;
    std::string rig;
  };
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("INPUT", arguments->input, kInputHelp)->required();
  AddInputOptions(command, &arguments->options);
  command->add_option("--camera", arguments->options.camera, "Camera 0..3 of a KITTI folder")
      ->check(CLI::Range(0, 3));
  command->add_option("--write-rig", arguments->rig,
                      "File to write what was recognised of the sensors to, for tvl run --rig");
  command->callback(
      [arguments] { RunInspect(arguments->input, arguments->options, arguments->rig); });
}

}  // namespace tvl
