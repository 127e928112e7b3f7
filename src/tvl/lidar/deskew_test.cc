#include "tvl/lidar/deskew.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/lidar/range_image.h"

namespace tvl {
namespace {

constexpr double kPeriod_s = 0.1;

struct MovingSensor {
  std::vector<Eigen::Vector3d> truth;     // in the sensor frame at the stamp
  std::vector<Eigen::Vector3f> measured;  // in the sensor frame when measured
  std::vector<float> time_offset_s;
};

// A sensor that moves by T_prev_cur a period looks at fixed points. World = sensor at the stamp;
// a period earlier it sits at T_prev_cur^-1, so its pose at time t is Exp(t / period Log T).
MovingSensor Look(const Rigid3d& T_prev_cur) {
  MovingSensor out;
  Rng rng(5);
  for (int i = 0; i < 2000; ++i) {
    const double t_s = rng.Uniform(-0.05, 0.05);
    const Eigen::Vector3d p(rng.Uniform(-60, 60), rng.Uniform(-60, 60), rng.Uniform(-3, 5));
    const Rigid3d T_stamp_t = Scale(t_s / kPeriod_s, T_prev_cur);
    out.truth.push_back(p);
    out.measured.push_back((T_stamp_t.Inverse() * p).cast<float>());
    out.time_offset_s.push_back(static_cast<float>(t_s));
  }
  return out;
}

TEST(Deskew, FixedPointsOfAMovingSensorComeOutRight) {
  Vector6d xi;
  xi << 0.01, -0.02, 0.15, 4.0, 0.3, -0.1;  // 40 m/s in a hard turn
  const Rigid3d T_prev_cur = Rigid3d::Exp(xi);
  const MovingSensor sensor = Look(T_prev_cur);
  const auto points = DeskewPoints(sensor.measured, sensor.time_offset_s, T_prev_cur, kPeriod_s);
  double worst_m = 0.0, uncorrected_m = 0.0;
  for (size_t i = 0; i < points.size(); ++i) {
    worst_m = std::max(worst_m, (points[i].cast<double>() - sensor.truth[i]).norm());
    uncorrected_m =
        std::max(uncorrected_m, (sensor.measured[i].cast<double>() - sensor.truth[i]).norm());
  }
  EXPECT_LT(worst_m, 1e-4);
  EXPECT_GT(uncorrected_m, 1.0);
}

TEST(Deskew, ForwardMotionMovesLatePointsForward) {
  // Measured 50 ms after the stamp at 10 m ahead, at 20 m/s: 11 m ahead of where the stamp was.
  const auto points =
      DeskewPoints({{10, 0, 0}, {10, 0, 0}}, {0.05f, -0.05f}, Rigid3d::Translation(2, 0, 0), 0.1);
  EXPECT_NEAR(points[0].x(), 11.0f, 1e-5f);
  EXPECT_NEAR(points[1].x(), 9.0f, 1e-5f);
}

TEST(Deskew, LeftTurnOfACounterClockwiseSweep) {
  // A point to the left is measured late on a counter-clockwise sweep; the sensor has turned left
  // by then, so at the stamp the point stood further to the left than it was seen.
  const float t_s = TimeOffset_s(1.5f, Deskew::kCounterClockwise, 0.1);
  EXPECT_GT(t_s, 0.0f);
  Vector6d xi = Vector6d::Zero();
  xi[2] = 0.1;
  const Eigen::Vector3f seen(10.0f * std::cos(1.5f), 10.0f * std::sin(1.5f), 0.0f);
  const auto points = DeskewPoints({seen}, {t_s}, Rigid3d::Exp(xi), 0.1);
  EXPECT_NEAR(std::atan2(points[0].y(), points[0].x()), 1.5 + 0.1 * t_s / 0.1, 1e-5);
}

TEST(Deskew, NothingToDo) {
  EXPECT_TRUE(DeskewPoints({}, {}, Rigid3d(), 0.1).empty());
  const std::vector<Eigen::Vector3f> points = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(DeskewPoints(points, {0, 0}, Rigid3d::Translation(3, 0, 0), 0.1), points);
  EXPECT_THROW(DeskewPoints(points, {0}, Rigid3d(), 0.1), Error);
  EXPECT_THROW(DeskewPoints(points, {0, 0}, Rigid3d(), 0.0), Error);
}

}  // namespace
}  // namespace tvl
