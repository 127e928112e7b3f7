// A drive that comes back to where it began, for tests of loops in the whole system only.
#pragma once

#include <memory>

#include "tvl/registration/test_world.h"
#include "tvl/sensor/dataset.h"

namespace tvl::synthetic {

// The world as it is after a motion.
inline World Moved(const World& world, const Rigid3d& T) {
  World moved;
  for (const Surface& surface : world.surfaces) {
    moved.surfaces.push_back(
        [surface, T_inverse = T.Inverse()](const Eigen::Vector3d& o, const Eigen::Vector3d& ray) {
          return surface(T_inverse * o, T_inverse.q() * ray);
        });
  }
  for (const Eigen::Vector2d& edge : world.edges) {
    moved.edges.emplace_back((T * Eigen::Vector3d(edge.x(), edge.y(), 0.0)).head<2>());
  }
  return moved;
}

// Houses of all sizes on both sides of a street, at x from begin_m to end_m.
inline World HousesBetween(double begin_m, double end_m, uint64_t seed) {
  World world;
  Rng rng(seed);
  for (const double side : {-1.0, 1.0}) {
    for (double x = begin_m; x < end_m; x += rng.Uniform(6.0, 12.0)) {
      const double width = rng.Uniform(3.0, 6.0);
      const double front = side * rng.Uniform(4.5, 9.0), back = front + side * 5.0;
      world.surfaces.push_back(Box({x, std::min(front, back), -1.7},
                                   {x + width, std::max(front, back), rng.Uniform(2.0, 6.0)}));
    }
  }
  return world;
}

// Forth along a street, on to a square from which nothing of it is seen, and back in reverse on the
// other side. Meanwhile the street has slid away. To the odometry, which cannot know, that is the
// same as an error of its own made in the square: the return ends beside the street as mapped, and
// only a loop can say that it is the same one. Frame by frame the odometry is right all the time.
class ReturnDrive {
 public:
  static constexpr size_t kFrames = 130;
  static constexpr double kStreetEnd_m = 70.0;

  ReturnDrive() : street_(HousesBetween(-20.0, kStreetEnd_m, 1)) {
    setup_.name = "synthetic return";
    setup_.calibration = CameraAndLidar();
    setup_.lidar = Lidar();
    setup_.lidar.max_range_m = 20.0;
    setup_.has_camera = false;
  }

  const SensorSetup& setup() const { return setup_; }
  static Rigid3d Slide() { return Rigid3d::Translation(1.2, -0.9, 0.0); }
  // The street as the way back finds it, in the coordinates of Driven().
  World street() const { return Moved(street_, FromStart(Slide())); }
  World street_as_mapped() const { return Moved(street_, FromStart(Rigid3d())); }

  // T_first_i as the odometry can know it ...
  static Rigid3d Driven(size_t i) { return PoseAt(0).Inverse() * PoseAt(i); }
  // ... and by the street.
  static Rigid3d Truth(size_t i) {
    return PoseAt(0).Inverse() * (IsBack(i) ? Slide().Inverse() : Rigid3d()) * PoseAt(i);
  }
  static bool IsBack(size_t i) { return 2 * i >= kFrames; }
  static double Along_m(size_t i) { return PoseAt(i).t().x(); }

  SensorFrame Frame(size_t i) const {
    SensorFrame frame;
    frame.id = static_cast<FrameId>(i);
    frame.stamp = Timestamp::FromSeconds(0.1 * static_cast<double>(i + 1));
    frame.scan = Scan(i);
    return frame;
  }

 private:
  // 10 m to 110 m and back, slow at both ends.
  static Rigid3d PoseAt(size_t i) {
    const double phase = 2.0 * kPi * static_cast<double>(i) / kFrames;
    return Rigid3d::Translation(60.0 - 50.0 * std::cos(phase), std::sin(phase), 0.0) *
           Rigid3d::Exp(Twist(0, 0, 0.05 * std::sin(phase), 0, 0, 0));
  }
  static Rigid3d FromStart(const Rigid3d& T) { return PoseAt(0).Inverse() * T; }

  std::shared_ptr<const LidarScan> Scan(size_t i) const {
    constexpr int kColumns = 720;
    World world = IsBack(i) ? Moved(street_, Slide()) : street_;
    for (const Surface& house : square_.surfaces) world.surfaces.push_back(house);
    world.surfaces.push_back(Plane({0, 0, 1}, -1.7));
    const Rigid3d T = PoseAt(i);
    Rng rng(17, i);
    auto scan = std::make_shared<LidarScan>();
    for (const double elevation : setup_.lidar.beam_elevation_rad) {
      for (int column = 0; column < kColumns; ++column) {
        const Eigen::Vector3d ray = Ray(2.0 * kPi * (column + 0.5) / kColumns, elevation);
        const double range = world.Range(T.t(), T.q() * ray) + 0.02 * rng.Normal();
        if (range > setup_.lidar.max_range_m) continue;
        scan->points.push_back((range * ray).cast<float>());
        scan->intensity.push_back(0.5f);
      }
    }
    return scan;
  }

  World street_;
  World square_ = HousesBetween(78.0, 135.0, 2);
  SensorSetup setup_;
};

}  // namespace tvl::synthetic
