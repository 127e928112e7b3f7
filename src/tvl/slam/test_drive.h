// A simulated drive through a synthetic street, with the sweep of the lidar in real motion and a
// camera that sees the same surfaces. For tests only.
#pragma once

#include <algorithm>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "tvl/registration/test_world.h"
#include "tvl/sensor/dataset.h"

namespace tvl::synthetic {

struct DriveOptions {
  size_t frames = 20;
  Deskew spin = Deskew::kNone;         // raw scans of a lidar that spins so; none: compensated
  Deskew point_times = Deskew::kNone;  // as of this spin; none: points have no times
  bool camera = false;
  double speed_m_s = 8.0;
  double sway_m = 1.0;  // half width of the snake line driven
  std::set<size_t> without_scan, without_image;
};

class Drive : public Dataset {
 public:
  explicit Drive(DriveOptions options) : options_(std::move(options)), world_(Street()) {
    setup_.name = "synthetic street";
    setup_.calibration = CameraAndLidar();
    setup_.lidar = Lidar();
    setup_.has_camera = options_.camera;
  }

  SensorSetup& setup() { return setup_; }
  const SensorSetup& setup() const override { return setup_; }
  size_t size() const override { return options_.frames; }

  SensorFrame Frame(size_t index) const override {
    SensorFrame frame;
    frame.id = static_cast<FrameId>(index);
    frame.stamp = Timestamp::FromSeconds(StampOf_s(index));
    if (options_.without_scan.count(index) == 0) frame.scan = Scan(index);
    if (options_.camera && options_.without_image.count(index) == 0) frame.image = Image(index);
    return frame;
  }

  // T_first_k of the lidar.
  Rigid3d Truth(size_t index) const {
    return PoseAt_s(StampOf_s(0)).Inverse() * PoseAt_s(StampOf_s(index));
  }

 private:
  static double StampOf_s(size_t index) { return 0.1 * static_cast<double>(index + 1); }

  Rigid3d PoseAt_s(double t_s) const {
    const double phase = 2.0 * kPi * t_s / 4.0;
    const double slope =
        options_.sway_m * 2.0 * kPi / 4.0 * std::cos(phase) / std::max(1.0, options_.speed_m_s);
    const Eigen::Vector3d angle(0.005 * std::sin(phase), 0.004 * std::cos(phase), std::atan(slope));
    return {ExpSo3(angle),
            Eigen::Vector3d(options_.speed_m_s * t_s, options_.sway_m * std::sin(phase), 0.0)};
  }

  // Ring after ring, each from azimuth 0 upwards, as KITTI stores them.
  std::shared_ptr<const LidarScan> Scan(size_t index) const {
    auto scan = std::make_shared<LidarScan>();
    const LidarModel& lidar = setup_.lidar;
    Rng rng(17, index);
    std::vector<Rigid3d> poses;
    for (int column = 0; column < kColumns; ++column) {
      const double signed_azimuth = std::remainder(Azimuth(column), 2.0 * kPi);
      const double offset_s = SpinOffset_s(signed_azimuth, options_.spin, lidar.sweep_s);
      poses.push_back(PoseAt_s(StampOf_s(index) + offset_s));
    }
    for (const double elevation : lidar.beam_elevation_rad) {
      for (int column = 0; column < kColumns; ++column) {
        const Rigid3d& T = poses[static_cast<size_t>(column)];
        const Eigen::Vector3d ray = Ray(Azimuth(column), elevation);
        const double range = world_.Range(T.t(), T.q() * ray) + 0.02 * rng.Normal();
        if (range > lidar.max_range_m) continue;
        scan->points.push_back((range * ray).cast<float>());
        scan->intensity.push_back(0.5f);
        if (options_.point_times != Deskew::kNone) {
          const double azimuth = std::remainder(Azimuth(column), 2.0 * kPi);
          scan->time_offset_s.push_back(
              static_cast<float>(SpinOffset_s(azimuth, options_.point_times, lidar.sweep_s)));
        }
      }
    }
    return scan;
  }

  cv::Mat Image(size_t index) const {
    const Camera& camera = setup_.calibration.camera;
    const Rigid3d T = PoseAt_s(StampOf_s(index)) * setup_.calibration.T_cam_lidar.Inverse();
    cv::Mat image(camera.height_px, camera.width_px, CV_8U);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const Eigen::Vector3d ray =
            (T.q() * camera.Unproject(Eigen::Vector2d(x, y)).homogeneous()).normalized();
        const double range = world_.Range(T.t(), ray);
        const double grey = 128.0 + Texture(T.t() + range * ray, range / camera.fx_px);
        image.at<uchar>(y, x) = cv::saturate_cast<uchar>(grey);
      }
    }
    return image;
  }

  // Grey of a place, -100..100: random cells of several sizes, those below three pixels fading.
  static double Texture(const Eigen::Vector3d& p, double pixel_m) {
    double sum = 0.0;
    for (const double cell_m : {0.15, 0.4, 1.2}) {
      const double share = std::clamp(cell_m / (3.0 * pixel_m) - 1.0, 0.0, 1.0);
      if (share > 0.0) sum += share * 45.0 * CellNoise(p / cell_m, cell_m);
    }
    return sum;
  }
  // Trilinear between random values at the corners of a unit grid, -1..1.
  static double CellNoise(const Eigen::Vector3d& p, double salt) {
    const Eigen::Vector3d low = p.array().floor(), f = p - low;
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1.0;
      uint64_t hash = static_cast<uint64_t>(1000.0 * salt);
      for (int axis = 0; axis < 3; ++axis) {
        const int bit = (corner >> axis) & 1;
        weight *= bit == 1 ? f[axis] : 1.0 - f[axis];
        hash = Rng::Mix(hash ^ static_cast<uint64_t>(static_cast<int64_t>(low[axis]) + bit + 4096));
      }
      sum += weight * (static_cast<double>(hash >> 11) * 0x1.0p-52 - 1.0);
    }
    return sum;
  }

  static constexpr int kColumns = 720;
  static double Azimuth(int column) { return 2.0 * kPi * (column + 0.5) / kColumns; }

  DriveOptions options_;
  World world_;
  SensorSetup setup_;
};

}  // namespace tvl::synthetic
