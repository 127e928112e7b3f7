#include "tvl/slam/pose_search.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

// Houses, poles and ground along x from begin_m to end_m: every street is another.
std::vector<Eigen::Vector3f> StreetPoints(double begin_m, double end_m, uint64_t seed) {
  std::vector<Eigen::Vector3f> points;
  Rng noise(seed);
  const auto add = [&](double x, double y, double z) {
    if (x < begin_m || x > end_m) return;
    points.emplace_back(static_cast<float>(x + 0.02 * noise.Normal()),
                        static_cast<float>(y + 0.02 * noise.Normal()),
                        static_cast<float>(z + 0.02 * noise.Normal()));
  };
  Rng rng(5);
  for (const double side : {-1.0, 1.0}) {
    for (double x = -60.0; x < 120.0;) {
      const double length = rng.Uniform(6.0, 14.0), front = side * rng.Uniform(7.0, 11.0);
      for (double along = 0.0; along < length; along += 0.2) {
        for (double z = 0.0; z < 4.0; z += 0.4) add(x + along, front, z);
      }
      const double pole = x + rng.Uniform(0.0, length);
      for (double z = 0.0; z < 4.0; z += 0.1) add(pole, side * 5.5, z);
      x += length + rng.Uniform(2.0, 8.0);
    }
  }
  for (double x = -60.0; x < 120.0; x += 0.4) {
    for (double y = -6.0; y < 6.0; y += 0.4) add(x, y, -1.7);
  }
  return points;
}

LocalMap MapOf(const std::vector<Eigen::Vector3f>& points, const Executor& executor) {
  LocalMap map{LocalMapOptions()};
  auto cloud = std::make_shared<KeyframeCloud>();
  cloud->planes.points = points;
  cloud->planes.intensity.assign(points.size(), 0.5f);
  map.Add({0, 0.0, Rigid3d(), cloud}, executor);
  return map;
}

// The map ends 50 m ahead; the vehicle has moved 24 m towards its end and turned a little.
TEST(AlignWithoutGuess, FindsAVehicleTowardsTheEndOfTheMap) {
  const Executor executor(2);
  const LocalMap map = MapOf(StreetPoints(-60.0, 50.0, 1), executor);
  const Rigid3d T_true(ExpSo3({0.0, 0.0, 0.1}), Eigen::Vector3d(24.0, -1.0, 0.0));
  std::vector<Eigen::Vector3f> scan;
  for (const Eigen::Vector3f& p : StreetPoints(-16.0, 64.0, 2)) {
    scan.push_back((T_true.Inverse() * p.cast<double>()).cast<float>());
  }
  const PoseSearchOptions options;
  const std::vector<Rigid3d> found = AlignWithoutGuess(scan, map, Rigid3d(), options.radius_m,
                                                       options.yaw_window_rad, options, executor);
  const auto is_right = [&](const Rigid3d& T) {
    const Rigid3d error = T_true.Inverse() * T;
    return error.t().norm() < 0.8 && error.RotationAngle() < 0.05;
  };
  ASSERT_FALSE(found.empty());
  EXPECT_TRUE(std::any_of(found.begin(), found.end(), is_right));
}

TEST(AlignWithoutGuess, GivesNothingWithoutAMap) {
  const PoseSearchOptions options;
  EXPECT_TRUE(AlignWithoutGuess(StreetPoints(-30.0, 30.0, 2), LocalMap{LocalMapOptions()},
                                Rigid3d(), 5.0, 0.1, options, Executor(1))
                  .empty());
}

TEST(AlternativeMotions, BeginWithTheMostProbableAndHoldStandingAndTheStamps) {
  MotionModel model{MotionModelOptions()};
  model.Update(Rigid3d::Translation(1.0, 0.0, 0.0), Matrix6d::Zero(), 1);
  FrameInterval interval;
  interval.periods = 1;
  interval.nearest_periods = 7;
  std::vector<double> lengths_m;
  for (const MotionPrediction& motion : AlternativeMotions(model, interval)) {
    lengths_m.push_back(motion.T_prev_cur.t().x());
  }
  EXPECT_NEAR(lengths_m.front(), 1.0, 1e-9);
  for (const double wanted_m : {0.0, 2.0, 3.0, 7.0}) {
    EXPECT_TRUE(std::any_of(lengths_m.begin(), lengths_m.end(), [&](double length_m) {
      return std::abs(length_m - wanted_m) < 1e-9;
    })) << wanted_m;
  }
}

TEST(IsReachable, NotSidewaysButRoundACorner) {
  MotionModel model{MotionModelOptions()};
  model.Update(Rigid3d(), Matrix6d::Identity() * 1e-6, 1);  // stands
  const auto is_reachable = [&](double x_m, double y_m, double yaw_rad) {
    return IsReachable(model, kMostLostPeriods, 0.1,
                       {ExpSo3({0.0, 0.0, yaw_rad}), Eigen::Vector3d(x_m, y_m, 0.0)});
  };
  EXPECT_TRUE(is_reachable(0.2, -0.4, 0.0)) << "the known pose is off by a little";
  EXPECT_FALSE(is_reachable(2.0, -11.0, 0.0));
  EXPECT_FALSE(is_reachable(10.0, -11.0, 0.0));
  EXPECT_TRUE(is_reachable(8.0, -8.0, -1.57));
  EXPECT_TRUE(is_reachable(12.0, -3.0, -1.5)) << "straight on, then round";
  EXPECT_FALSE(is_reachable(8.0, 8.0, -1.57)) << "turned right, and went left";
  EXPECT_TRUE(is_reachable(12.0, 3.5, 0.1)) << "into the next lane";
  EXPECT_TRUE(is_reachable(-2.0, 0.2, 0.0)) << "from a stand backwards";
}

TEST(IsReachable, FollowsTheMotionThroughLostScansAndNotBackOrSideways) {
  MotionModel model{MotionModelOptions()};
  const auto reaches = [&](double x_m, double y_m) {
    return IsReachable(model, kMostLostPeriods, 0.1, Rigid3d::Translation(x_m, y_m, 0.0));
  };
  EXPECT_TRUE(reaches(30.0, -20.0)) << "no velocity is known";
  model.Update(Rigid3d::Translation(2.5, 0.0, 0.0), Matrix6d::Zero(), 1);
  for (const int lost : {0, 1, 5, 30}) EXPECT_TRUE(reaches(2.5 * (lost + 1), 0.0)) << lost;
  EXPECT_TRUE(reaches(2.4, 0.1));
  EXPECT_FALSE(reaches(-4.3, 3.2));
  EXPECT_FALSE(reaches(0.0, 0.0)) << "from 25 m/s to nothing in a frame";
  EXPECT_FALSE(reaches(4.5, -3.5));
  // Three seconds later it may have braked, or turned off.
  const auto reaches_later = [&](double x_m, double y_m) {
    return IsReachable(model, 30, 0.1, Rigid3d::Translation(x_m, y_m, 0.0));
  };
  EXPECT_TRUE(reaches_later(60.0, -10.0));
  EXPECT_FALSE(reaches_later(20.0, -40.0));
  EXPECT_FALSE(reaches_later(-10.0, 0.0));
}

TEST(PoseSearchOptions, NameTheBadField) {
  PoseSearchOptions options;
  options.radius_m = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
