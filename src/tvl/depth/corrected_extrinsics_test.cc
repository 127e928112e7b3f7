#include "tvl/depth/corrected_extrinsics.h"

#include <gtest/gtest.h>

#include "tvl/base/units.h"

namespace tvl {
namespace {

Rigid3d ForwardCamera() {
  Eigen::Matrix3d R;  // lidar x forward, y left, z up -> camera z forward, x right, y down
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {R, Eigen::Vector3d(0.0, -0.08, -0.27)};
}

// The correction as the lidar model defines it: p turns about p x z.
Eigen::Vector3d Corrected(const Eigen::Vector3d& p, double correction_rad) {
  return ExpSo3(correction_rad * p.cross(Eigen::Vector3d::UnitZ()).normalized()) * p;
}

TEST(CorrectedExtrinsics, CorrectedPointsLandWhereStoredOnesDid) {
  const Rigid3d T_cam_lidar = ForwardCamera();
  const double correction_rad = DegToRad(0.205);
  const Rigid3d T = ExtrinsicsOfCorrectedPoints(T_cam_lidar, correction_rad);
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(20, 0, 0), Eigen::Vector3d(8, 0, -1.6)}) {
    EXPECT_GT(Corrected(p, correction_rad).z(), p.z()) << "points rise";
    EXPECT_NEAR((T * Corrected(p, correction_rad) - T_cam_lidar * p).norm(), 0.0, 1e-9);
  }
  // Off the axis the two differ by the share of the tilt that acts as roll: little.
  const Eigen::Vector3d side(14, 14, -1);
  const Eigen::Vector3d was = T_cam_lidar * side, is = T * Corrected(side, correction_rad);
  EXPECT_LT((is.hnormalized() - was.hnormalized()).norm(), 0.003);
}

TEST(CorrectedExtrinsics, NothingToDo) {
  const Rigid3d T = ExtrinsicsOfCorrectedPoints(ForwardCamera(), 0.0);
  EXPECT_TRUE(T.Matrix().isApprox(ForwardCamera().Matrix(), 1e-12));
  const Rigid3d up(Eigen::Quaterniond::Identity(), Eigen::Vector3d(1, 2, 3));  // looks along z
  EXPECT_TRUE(ExtrinsicsOfCorrectedPoints(up, 0.1).Matrix().isApprox(up.Matrix(), 1e-12));
}

}  // namespace
}  // namespace tvl
