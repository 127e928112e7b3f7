#include "tvl/pose_graph/constraint_error.h"

#include <Eigen/Cholesky>

#include "tvl/base/check.h"
#include "tvl/base/index.h"

namespace tvl {

Vector6d ConstraintError(const PoseConstraint& constraint, const Rigid3d& T_world_from,
                         const Rigid3d& T_world_to) {
  return (constraint.T_from_to.Inverse() * (T_world_from.Inverse() * T_world_to)).Log();
}

ConstraintJacobians LinearizeConstraint(const PoseConstraint& constraint,
                                        const Rigid3d& T_world_from, const Rigid3d& T_world_to) {
  const Rigid3d T_from_to = T_world_from.Inverse() * T_world_to;
  ConstraintJacobians result;
  result.e = (constraint.T_from_to.Inverse() * T_from_to).Log();
  // Z^-1 T_from_to Exp(d_to) is e right-perturbed by d_to; Exp(-d_from) T_from_to carries d_from
  // to the same side with the adjoint.
  result.J_to = RightJacobianInverseSe3(result.e);
  result.J_from = -result.J_to * T_from_to.Inverse().Adjoint();
  return result;
}

ConstraintBlocks NormalBlocks(const PoseConstraint& constraint, double weight,
                              const Rigid3d& T_world_from, const Rigid3d& T_world_to) {
  const ConstraintJacobians lin = LinearizeConstraint(constraint, T_world_from, T_world_to);
  const Matrix6d information = weight * constraint.information;
  const Matrix6d information_J_from = information * lin.J_from;
  const Matrix6d information_J_to = information * lin.J_to;
  ConstraintBlocks blocks;
  blocks.H_ff.noalias() = lin.J_from.transpose() * information_J_from;
  blocks.H_ft.noalias() = lin.J_from.transpose() * information_J_to;
  blocks.H_tt.noalias() = lin.J_to.transpose() * information_J_to;
  blocks.b_f.noalias() = information_J_from.transpose() * lin.e;
  blocks.b_t.noalias() = information_J_to.transpose() * lin.e;
  return blocks;
}

double SquaredError(const PoseConstraint& constraint, const Rigid3d& T_world_from,
                    const Rigid3d& T_world_to) {
  const Vector6d e = ConstraintError(constraint, T_world_from, T_world_to);
  return e.dot(constraint.information * e);
}

double SquaredError(const PoseConstraint& constraint, const std::vector<Rigid3d>& T_world) {
  return SquaredError(constraint, T_world[Index(constraint.from)], T_world[Index(constraint.to)]);
}

void CheckConstraint(const PoseConstraint& constraint, int poses, const char* what) {
  const int from = constraint.from, to = constraint.to;
  TVL_CHECK_INPUT(from >= 0 && from < poses && to >= 0 && to < poses && from != to)
      << what << " from pose " << from << " to pose " << to << ": the graph has poses 0 to "
      << poses - 1;
  const Matrix6d& information = constraint.information;
  const bool is_symmetric =
      information.allFinite() && (information - information.transpose()).cwiseAbs().maxCoeff() <=
                                     1e-6 * information.cwiseAbs().maxCoeff();
  TVL_CHECK_INPUT(is_symmetric && information.llt().info() == Eigen::Success)
      << what << " from pose " << from << " to pose " << to
      << ": its information is not symmetric and positive definite";
  TVL_CHECK_INPUT(constraint.T_from_to.t().allFinite() &&
                  constraint.T_from_to.q().coeffs().allFinite())
      << what << " from pose " << from << " to pose " << to << ": its transform is not finite";
}

}  // namespace tvl
