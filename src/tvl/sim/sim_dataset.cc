#include "tvl/sim/sim_dataset.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/parallel.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/io/profile.h"
#include "tvl/sim/camera_renderer.h"
#include "tvl/sim/changes.h"
#include "tvl/sim/lidar_sensor.h"
#include "tvl/sim/prototypes.h"
#include "tvl/sim/town.h"
#include "tvl/sim/traffic.h"

namespace tvl::sim {
namespace {

constexpr uint64_t kSunStream = 701;

// Camera 0 and its place of KITTI odometry 00, rounded.
Calibration KittiLikeCalibration() {
  Calibration c;
  c.camera.fx_px = c.camera.fy_px = 718.856;
  c.camera.cx_px = 607.1928, c.camera.cy_px = 185.2157;
  c.camera.width_px = 1241, c.camera.height_px = 376;
  // Axes of the lidar in the camera, turned by a few milliradians as mounted.
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Eigen::Quaterniond mounting = Eigen::AngleAxisd(-0.0081, Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(-0.0005, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(-0.0072, Eigen::Vector3d::UnitX());
  const Eigen::Vector3d t(-0.012, -0.08, -0.27);
  c.T_cam_lidar = Rigid3d(mounting * Eigen::Quaterniond(R), t);
  c.T_cam0_lidar = c.T_cam_lidar;
  return c;
}

TownOptions TownFor(const SimOptions& options, const Drive& drive) {
  TownOptions town;
  town.seed = options.seed;
  town.is_open = options.preset == "open";
  town.is_repeating = options.preset == "aliasing";
  town.open_m = drive.open_m;
  return town;
}

TrafficOptions TrafficFor(const SimOptions& options) {
  TrafficOptions traffic;
  traffic.seed = options.seed;
  if (options.preset == "traffic") {
    traffic.oncoming_every_s = 3.0;
    traffic.leaders = 3, traffic.followers = 2, traffic.leader_gap_s = 4.0;
    traffic.pedestrian_every_m = 6.0;
  }
  if (options.preset == "open") traffic.pedestrian_every_m = 0.0;
  // A tunnel of one lane; a deserted street.
  if (options.preset == "tunnel" || options.preset == "aliasing" || !options.tunnel.IsEmpty()) {
    traffic.oncoming_every_s = 0.0, traffic.pedestrian_every_m = 0.0;
    traffic.leaders = traffic.followers = 0;
  }
  return traffic;
}

SceneDescription Describe(const SimOptions& options, const Drive& drive) {
  const Prototypes prototypes = BuildPrototypes(options.seed);
  SceneDescription description =
      BuildTown(drive.route, drive.terrain, prototypes, TownFor(options, drive));
  description.movers =
      std::make_shared<Traffic>(drive.route, drive.terrain, drive.travel, prototypes,
                                drive.frames * kFrameInterval_s, TrafficFor(options));
  ChangeOptions changes;
  changes.seed = options.seed, changes.share = options.changes;
  return WithChanges(std::move(description), prototypes,
                     {drive.T_world_lidar, drive.frames * kFrameInterval_s}, changes);
}

LidarSensorOptions LidarOptionsFor(const SimOptions& options) {
  LidarSensorOptions lidar;
  lidar.seed = options.seed;
  lidar.has_errors = !options.clean;
  return lidar;
}

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

SensorSetup SensorsFor(const SimOptions& options) {
  SensorSetup setup;
  setup.name = "sim:" + options.preset;
  setup.calibration = KittiLikeCalibration();
  setup.lidar = LoadProfile("kitti");
  if (options.clean) setup.lidar.vertical_correction_rad = 0.0;
  setup.has_camera = options.has_camera;
  setup.seed = options.seed;
  return setup;
}

struct SimDataset::Sensors {
  Scene scene;
  LidarSensor lidar;
  CameraRenderer camera;
  Executor executor;

  Sensors(const SimOptions& options, const SensorSetup& setup, const Drive& drive)
      : scene(Describe(options, drive)),
        lidar(setup.lidar, LidarOptionsFor(options)),
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

SensorFrame SimDataset::Frame(size_t index) const {
  TVL_CHECK(index < size()) << "frame " << index << " of " << size();
  const double stamp_s = static_cast<double>(index) * kFrameInterval_s;
  const double half_sweep_s = 0.5 * setup_.lidar.sweep_s;
  SensorFrame frame;
  frame.id = static_cast<FrameId>(index);
  frame.stamp = Timestamp::FromSeconds(stamp_s);

  LidarSweep sweep;
  sweep.T_world_lidar = [&](double offset_s) {
    return drive_.T_world_lidar.At(stamp_s + offset_s);
  };
  sweep.frame = index;
  sweep.is_clockwise = options_.raw != Deskew::kCounterClockwise;
  sweep.is_compensated = options_.raw == Deskew::kNone;
  const SceneView view = sensors_->scene.View(stamp_s - half_sweep_s, stamp_s + half_sweep_s);
  LidarScan scan = sensors_->lidar.Scan(view, sweep, sensors_->executor);
  if (!options_.exact_rings) scan.ring.clear(), scan.time_offset_s.clear();
  frame.scan = std::make_shared<LidarScan>(std::move(scan));

  if (options_.has_camera) {
    CameraShot shot;
    shot.T_world_cam = Truth_T_world_lidar(index) * setup_.calibration.T_cam_lidar.Inverse();
    shot.time_s = stamp_s;
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
  return std::make_unique<SimDataset>(ParseSimUri(uri));
}

}  // namespace tvl::sim
