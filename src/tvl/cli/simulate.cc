// tvl simulate: writes a simulated drive to disk, in the layout of KITTI odometry.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <optional>

#include "tvl/cli/commands.h"
#include "tvl/cli/progress.h"
#include "tvl/sim/drive_writer.h"

namespace tvl {
namespace {

struct SimulateArguments {
  std::string out;
  sim::SimOptions options;
  std::string raw = "none", tunnel, open, night, road = "rich", beam_error_shape = "independent";
  std::optional<int> frames;
  int threads = 2;
  bool no_camera = false;
};

sim::SimOptions Resolve(const SimulateArguments& arguments) {
  sim::SimOptions options = arguments.options;
  options.raw = sim::ParseSpin(arguments.raw);
  options.has_camera = !arguments.no_camera;
  options.road = sim::ParseRoad(arguments.road);
  options.beam_error_shape = sim::ParseBeamErrorShape(arguments.beam_error_shape);
  options.frames = arguments.frames.value_or(sim::DefaultFrames(options));
  if (!arguments.tunnel.empty())
    options.tunnel = sim::ParseFrameRange(arguments.tunnel, "--tunnel");
  if (!arguments.open.empty()) options.open = sim::ParseFrameRange(arguments.open, "--open");
  if (!arguments.night.empty()) options.night = sim::ParseFrameRange(arguments.night, "--night");
  return options;
}

void Simulate(const SimulateArguments& arguments) {
  const sim::SimDataset drive(Resolve(arguments));
  {
    Progress progress(std::cerr, StderrIsTerminal(), "frames", drive.size());
    sim::WriteDrive(drive, arguments.out, arguments.threads,
                    [&](size_t done) { progress.Update(done, "simulate"); });
  }
  std::cout << drive.size() << " frames, " << static_cast<int>(drive.Length_m()) << " m, in "
            << arguments.out << "\n";
}

}  // namespace

void AddSimulateCommand(CLI::App& app) {
  auto arguments = std::make_shared<SimulateArguments>();
  sim::SimOptions& o = arguments->options;
  CLI::App* command = app.add_subcommand(
      "simulate", "Simulate a drive: camera, lidar and truth, in KITTI's layout");
  command->add_option("--out", arguments->out, "Folder to write")->required();
  command
      ->add_option(
          "--preset", o.preset,
          "city loop reverse traffic aliasing nightloop lateloop tunnel open jam passing highway")
      ->capture_default_str();
  command->add_option("--trajectory", o.trajectory_file,
                      "KITTI poses to drive along instead of the preset's route");
  command->add_option("--seed", o.seed, "Decides everything random")->capture_default_str();
  command->add_option("--frames", arguments->frames,
                      "10 a second; 0: all of --trajectory; default: 300, or the whole highway");
  command->add_option("--raw", arguments->raw,
                      "Scans as measured, not compensated: spin of the scanner, cw or ccw");
  command->add_option("--tunnel", arguments->tunnel, "Frames A:B lead through a tunnel");
  command->add_option("--open", arguments->open, "Frames A:B lead through open country");
  command->add_option("--night", arguments->night, "Frames A:B are dark");
  command
      ->add_option("--changes", o.changes,
                   "Share (0..1) of parked cars, bins and plants that change between two passes")
      ->capture_default_str();
  command
      ->add_option("--lateral", o.lateral_m,
                   "Later laps lead this far left of the first, m (0..2.5; loop presets only)")
      ->capture_default_str();
  command
      ->add_option(
          "--speed", o.speed_m_s,
          "Drive at this speed from the first frame on, m/s (1..40), along a straight road")
      ->capture_default_str();
  command->add_option("--road", arguments->road, "Of highway: rich, poor or wet")
      ->capture_default_str();
  command->add_option("--faster", o.faster, "Of tunnel: after its stop this share faster, e.g. 0.4")
      ->capture_default_str();
  command->add_flag("--turn", o.is_turning, "With --speed: begin in the middle of a long bend");
  command->add_option("--beams", o.beams, "Of the lidar: 16, 32 or 64 (HDL-64E)")
      ->capture_default_str();
  command
      ->add_option("--beam-errors", o.beam_errors,
                   "Constant errors of the beams, times the usual ones (0..10)")
      ->capture_default_str();
  command
      ->add_option("--beam-error-shape", arguments->beam_error_shape,
                   "Over the rings: independent or sine (one period, the same rms)")
      ->capture_default_str();
  command->add_flag("--clean", o.clean, "A lidar without errors");
  command->add_flag("--no-camera", arguments->no_camera, "Lidar only: much faster");
  command
      ->add_option("--camera-delay-ms", o.camera_delay_ms,
                   "Images show the scene this much after the scans' instant, ms (-100..100)")
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "Frames made at a time")
      ->capture_default_str();
  command->callback([arguments] { Simulate(*arguments); });
}

}  // namespace tvl
