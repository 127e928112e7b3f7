#include "tvl/eval/relative_error.h"

#include <gtest/gtest.h>

#include "tvl/eval/path_length.h"
#include "tvl/eval/test_paths.h"

namespace tvl {
namespace {

TEST(RelativeError, GoldenPerFrame) {
  // Two of four steps are 3 cm and 4 cm too long: rms sqrt((9 + 16) / 4) cm = 2.5 cm.
  std::vector<Rigid3d> truth, estimate;
  const double estimate_z_m[] = {0.0, 1.03, 2.03, 3.07, 4.07};
  for (int i = 0; i < 5; ++i) {
    truth.push_back(Rigid3d::Translation(0, 0, i));
    estimate.push_back(Rigid3d::Translation(0, 0, estimate_z_m[i]));
  }
  const RelativeError error = RelativeErrorPerFrame(truth, estimate);
  EXPECT_EQ(error.count, 4U);
  EXPECT_NEAR(error.translation_rmse_m, 0.025, 1e-12);
  EXPECT_NEAR(error.rotation_rmse_deg, 0.0, 1e-9);
}

TEST(RelativeError, GoldenPerDistance) {
  // Steps of 1.5 m: the first frame more than 10 m on is the seventh, 10.5 m; 2 % of it is 0.21 m.
  const std::vector<Rigid3d> truth = ConstantMotion(20, 1.5, 0.0);
  const RelativeError error = RelativeErrorPerDistance(truth, Scaled(truth, 1.02), 10.0);
  EXPECT_EQ(error.count, 13U);
  EXPECT_NEAR(error.translation_rmse_m, 0.21, 1e-12);
  EXPECT_EQ(RelativeErrorPerDistance(truth, truth, 100.0).count, 0U);
}

TEST(RelativeError, RotationIsTheAngleOfTheDifference) {
  const std::vector<Rigid3d> truth = ConstantMotion(30, 1.0, 0.02);
  const RelativeError error = RelativeErrorPerFrame(truth, ConstantMotion(30, 1.0, 0.025));
  EXPECT_NEAR(error.rotation_rmse_deg, RadToDeg(0.005), 1e-9);
}

TEST(ErrorOfMotion, IsTheD_OfTable1) {
  // Truth: 10 m ahead and a quarter turn left. Estimate: 10.3 m ahead, 0.4 m right, 91 deg; both
  // in worlds of their own.
  const Rigid3d truth(ExpSo3({0, -DegToRad(90.0), 0}), Eigen::Vector3d(0, 0, 10));
  const Rigid3d estimate(ExpSo3({0, -DegToRad(91.0), 0}), Eigen::Vector3d(0.4, 0, 10.3));
  const Rigid3d world(ExpSo3({0.1, 0.2, 0.3}), Eigen::Vector3d(1, 2, 3));
  const MotionError error = ErrorOfMotion(world, world * truth, Rigid3d(), estimate);
  EXPECT_NEAR(error.translation_m, 0.5, 1e-12);
  EXPECT_NEAR(error.rotation_deg, 1.0, 1e-9);
}

TEST(PathLengths, AddUpTheSteps) {
  const std::vector<double> lengths_m = PathLengths(
      {Rigid3d(), Rigid3d::Translation(3, 4, 0), Rigid3d::Translation(3, 4, 12), Rigid3d()});
  EXPECT_EQ(lengths_m, (std::vector<double>{0.0, 5.0, 17.0, 30.0}));
  EXPECT_EQ(IndexAfter(lengths_m, 0, 5.0), 2U);  // more than, not at least
  EXPECT_EQ(IndexAfter(lengths_m, 1, 11.0), 2U);
  EXPECT_FALSE(IndexAfter(lengths_m, 0, 30.0).has_value());
}

}  // namespace
}  // namespace tvl
