#include "tvl/sim/sim_dataset.h"

#include <algorithm>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/parallel.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/sensor/faulty_dataset.h"
#include "tvl/sim/camera_renderer.h"
#include "tvl/sim/preset_scene.h"

namespace tvl::sim {
namespace {

constexpr uint64_t kSunStream = 701;

CameraRenderOptions CameraOptionsFor(const SimOptions& options) {
  CameraRenderOptions camera;
  camera.seed = options.seed;
  camera.has_identical_houses = options.preset == "aliasing";
  Rng rng(options.seed, kSunStream);
  camera.lighting.sun_azimuth_rad = rng.Uniform(0.0, 2.0 * kPi);
  camera.lighting.sun_elevation_rad = rng.Uniform(0.6, 0.95);
  return camera;
}

const SimOptions& Checked(const SimOptions& options) {
  options.Check();
  return options;
}

}  // namespace

struct SimDataset::Sensors {
  Scene scene;
  LidarSensor lidar;
  CameraRenderer camera;
  Executor executor;

  Sensors(const SimOptions& options, const SensorSetup& setup, const Drive& drive)
      : scene(DescribeScene(options, drive)),
        lidar(setup.lidar, LidarErrorsFor(options)),
        camera(scene, setup.calibration.camera, CameraOptionsFor(options)),
        executor(options.threads) {}
};

SimDataset::SimDataset(const SimOptions& options)
    : options_(Checked(options)),
      setup_(SensorsFor(options)),
      drive_(PlanDrive(options, setup_.calibration.T_cam0_lidar)),
      sensors_(std::make_unique<const Sensors>(options_, setup_, drive_)) {}

SimDataset::~SimDataset() = default;

const Scene& SimDataset::scene() const { return sensors_->scene; }

Rigid3d SimDataset::Truth_T_world_lidar(size_t index) const {
  return drive_.T_world_lidar.At(static_cast<double>(index) * kFrameInterval_s);
}

double SimDataset::Length_m() const {
  const double end_s = static_cast<double>(size() - 1) * kFrameInterval_s;
  return drive_.travel.Way_m(end_s) - drive_.travel.Way_m(0.0);
}

Timestamp SimDataset::Stamp(size_t index) const {
  return Timestamp::FromSeconds(static_cast<double>(index) * kFrameInterval_s);
}

SensorFrame SimDataset::Frame(size_t index) const {
  TVL_CHECK(index < size()) << "frame " << index << " of " << size();
  const double stamp_s = static_cast<double>(index) * kFrameInterval_s;
  const double half_sweep_s = 0.5 * setup_.lidar.sweep_s;
  SensorFrame frame;
  frame.id = static_cast<FrameId>(index);
  frame.stamp = Stamp(index);

  LidarSweep sweep;
  sweep.T_world_lidar = [&](double offset_s) {
    return drive_.T_world_lidar.At(stamp_s + offset_s);
  };
  sweep.frame = index;
  sweep.is_clockwise = options_.raw != Deskew::kCounterClockwise;
  sweep.is_compensated = options_.raw == Deskew::kNone;
  const SceneView view = sensors_->scene.View(stamp_s - half_sweep_s, stamp_s + half_sweep_s);
  LidarScan scan = sensors_->lidar.Scan(view, sweep, sensors_->executor);
  if (!options_.HasRings()) scan.ring.clear(), scan.time_offset_s.clear();
  frame.scan = std::make_shared<LidarScan>(std::move(scan));

  if (options_.has_camera) {
    CameraShot shot;
    shot.time_s = stamp_s + 1e-3 * options_.camera_delay_ms;
    shot.T_world_cam =
        drive_.T_world_lidar.At(shot.time_s) * setup_.calibration.T_cam_lidar.Inverse();
    shot.frame = index;
    shot.night = drive_.night.Contains(static_cast<int>(index));
    frame.image = sensors_->camera.Render(shot, sensors_->executor);
  }
  return frame;
}

std::vector<Rigid3d> SimDataset::Truth_T_first_cam0() const {
  const Rigid3d T_lidar_cam0 = setup_.calibration.T_cam0_lidar.Inverse();
  const Rigid3d T_first_world = (Truth_T_world_lidar(0) * T_lidar_cam0).Inverse();
  std::vector<Rigid3d> poses;
  for (size_t i = 0; i < size(); ++i) {
    poses.push_back(T_first_world * Truth_T_world_lidar(i) * T_lidar_cam0);
  }
  if (!poses.empty()) poses.front() = Rigid3d();
  return poses;
}

std::unique_ptr<Dataset> OpenSimulation(const std::string& uri) {
  const SimOptions options = ParseSimUri(uri);
  auto drive = std::make_unique<SimDataset>(options);
  if (options.faults.empty()) return drive;
  return std::make_unique<FaultyDataset>(std::move(drive), ParseFaults(options.faults));
}

}  // namespace tvl::sim
