#include "tvl/depth/corrected_extrinsics.h"

namespace tvl {

Rigid3d ExtrinsicsOfCorrectedPoints(const Rigid3d& T_cam_lidar, double correction_rad) {
  const Eigen::Vector3d axis_lidar = T_cam_lidar.q().conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d turn = axis_lidar.cross(Eigen::Vector3d::UnitZ());
  if (turn.norm() < 1e-3) return T_cam_lidar;
  const Rigid3d T_corrected_stored(ExpSo3(correction_rad * turn.normalized()),
                                   Eigen::Vector3d::Zero());
  return T_cam_lidar * T_corrected_stored.Inverse();
}

}  // namespace tvl
