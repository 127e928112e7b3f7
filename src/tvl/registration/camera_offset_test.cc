#include "tvl/registration/camera_offset.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/registration/test_edges.h"

namespace tvl {
namespace {

using test_edges::GivenExtrinsics;
using test_edges::Scene;
using test_edges::TestCamera;

// Of the vehicle: rotation (rad/s) and translation (m/s), lidar axes.
Vector6d Velocity(double forward_m_s, double left_rad_s) {
  Vector6d velocity = Vector6d::Zero();
  velocity[2] = left_rad_s;
  velocity[3] = forward_m_s;
  return velocity;
}

Vector6d WindingRoad(int image) { return Velocity(9.0 + 3.0 * (image % 3), 0.2 * (image % 5 - 2)); }
Vector6d StraightRoad(int) { return Velocity(9.0, 0.0); }

// What is found from 16 images of a camera whose images are late and which sits elsewhere than
// given; read as if they were late by `known_s`.
CameraOffsetEstimate Drive(Vector6d (*velocity)(int), double delay_s,
                           const Eigen::Vector3d& translation_m, double known_s = 0.0) {
  CameraOffset offset{CameraOffsetOptions()};
  int answers = 0;
  for (int image = 0; image < 16; ++image) {
    Scene scene(static_cast<uint64_t>(image) + 1);
    const Vector6d xi = velocity(image);
    const Rigid3d given = GivenExtrinsics();
    const Rigid3d moved(Eigen::Quaterniond::Identity(), translation_m);
    const SegmentedScan scan = scene.Scan();
    answers += offset.Add(
        FindEdgeProfiles(scene.See(moved * given * Rigid3d::Exp(-delay_s * xi)), scan, scan.points,
                         TestCamera(), given * Rigid3d::Exp(-known_s * xi), xi, 400),
        {Eigen::Vector3d::Zero(), known_s});
  }
  EXPECT_EQ(answers, 2) << "every eighth image";
  return offset.estimate();
}

TEST(CameraOffset, FindsThatImagesAreLateOrEarly) {
  for (const double delay_s : {0.0, 0.03, -0.02}) {
    const CameraOffsetEstimate found = Drive(WindingRoad, delay_s, Eigen::Vector3d::Zero());
    EXPECT_TRUE(IsDelayObserved(found)) << found.delay_sigma_s;
    EXPECT_NEAR(found.delay_s, delay_s, 0.005);
    EXPECT_LT(std::abs(found.delay_s - delay_s), 3.0 * found.delay_sigma_s);
  }
}

TEST(CameraOffset, FindsTheRestOfADelayThatIsKnownInPart) {
  const CameraOffsetEstimate found = Drive(WindingRoad, 0.03, Eigen::Vector3d::Zero(), 0.025);
  EXPECT_NEAR(found.delay_s, 0.03, 0.004);
}

TEST(CameraOffset, FindsWhereTheCameraSits) {
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d translation_m = 0.05 * Eigen::Vector3d::Unit(axis);
    const CameraOffsetEstimate found = Drive(WindingRoad, 0.0, translation_m);
    for (int i = 0; i < 3; ++i) {
      const double error_m = std::abs(found.translation_m[i] - translation_m[i]);
      EXPECT_LT(error_m, 3.0 * found.translation_sigma_m[i]) << axis << i;
      EXPECT_LT(error_m, i == 2 ? 0.05 : 0.02) << axis << i;
    }
  }
}

TEST(CameraOffset, AConstantSpeedStraightOnTellsNoDelay) {
  const CameraOffsetEstimate found = Drive(StraightRoad, 0.0, Eigen::Vector3d::Zero());
  EXPECT_GT(found.images, 0);
  EXPECT_FALSE(IsDelayObserved(found));
  EXPECT_FALSE(IsPlaceObserved(found, 2)) << "nor the place along the way";
  EXPECT_TRUE(IsPlaceObserved(found, 0));
}

TEST(CameraOffset, SaysNothingOfImagesOfSomethingElse) {
  CameraOffset offset{CameraOffsetOptions()};
  for (uint64_t image = 1; image <= 8; ++image) {
    Scene scene(image), other(image + 100);
    const SegmentedScan scan = scene.Scan();
    EXPECT_FALSE(
        offset.Add(FindEdgeProfiles(other.See(GivenExtrinsics()), scan, scan.points, TestCamera(),
                                    GivenExtrinsics(), WindingRoad(static_cast<int>(image)), 400),
                   {}));
  }
  EXPECT_EQ(offset.estimate().images, 0);
  EXPECT_FALSE(IsDelayObserved(offset.estimate()));
}

TEST(CameraOffset, OptionsAreChecked) {
  CameraOffsetOptions options;
  options.max_images = 3;
  EXPECT_THROW(CameraOffset{options}, InputError);
  options = {};
  options.max_delay_s = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
