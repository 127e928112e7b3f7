#include "tvl/sim/sensors.h"

#include <Eigen/Geometry>

#include "tvl/base/units.h"
#include "tvl/io/profile.h"

namespace tvl::sim {
namespace {

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

// Beams at equal angles, topmost first.
LidarModel EvenBeams(int beams, double first_deg, double last_deg) {
  LidarModel model;
  model.name = std::to_string(beams) + " beams";
  for (int i = 0; i < beams; ++i) {
    model.beam_elevation_rad.push_back(
        DegToRad(first_deg + (last_deg - first_deg) * i / (beams - 1)));
  }
  model.columns = 1800;  // 0.2 deg: scanners of 16 and 32 beams at 10 Hz
  // The least of the data sheets of such scanners; 32 beams are sold with up to 200 m.
  model.max_range_m = 100.0;
  return model;
}

LidarModel LidarFor(const SimOptions& options) {
  if (options.beams == 16) return EvenBeams(16, 15.0, -15.0);
  if (options.beams == 32) return EvenBeams(32, 15.0, -25.0);
  LidarModel model = LoadProfile("kitti");
  if (options.clean) model.vertical_correction_rad = 0.0;
  return model;
}

}  // namespace

SensorSetup SensorsFor(const SimOptions& options) {
  SensorSetup setup;
  setup.name = "sim:" + options.preset;
  setup.calibration = KittiLikeCalibration();
  setup.lidar = LidarFor(options);
  setup.has_camera = options.has_camera;
  setup.seed = options.seed;
  return setup;
}

LidarSensorOptions LidarErrorsFor(const SimOptions& options) {
  LidarSensorOptions lidar;
  lidar.seed = options.seed;
  lidar.has_errors = !options.clean;
  lidar.beam_range_sigma_m *= options.beam_errors;
  lidar.beam_elevation_sigma_rad *= options.beam_errors;
  lidar.beam_error_shape = options.beam_error_shape;
  if (options.beams != 64) {
    lidar.columns = 1808;  // firings of 55.3 us in 0.1 s: VLP-16, VLP-32C data sheets
    lidar.max_range_m = 100.0;
  }
  return lidar;
}

}  // namespace tvl::sim
