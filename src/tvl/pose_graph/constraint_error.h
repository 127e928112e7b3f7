// Residual of a measured relative pose (paper 6.3). Eq. (12) as printed vanishes only for the
// inverse measurement and Eq. (13) mixes metres and radians; with Z = T_from_to it is here
// e = Log(Z^-1 T_world_from^-1 T_world_to), weighted by its information.
#pragma once

#include <vector>

#include "tvl/geometry/rigid3.h"
#include "tvl/map/pose_graph.h"

namespace tvl {

// e = [rotation (rad), translation (m)] in the frame of `to`.
Vector6d ConstraintError(const PoseConstraint& constraint, const Rigid3d& T_world_from,
                         const Rigid3d& T_world_to);

// The error and its derivatives by right perturbations of the two poses.
struct ConstraintJacobians {
  Vector6d e;
  Matrix6d J_from, J_to;
};
ConstraintJacobians LinearizeConstraint(const PoseConstraint& constraint,
                                        const Rigid3d& T_world_from, const Rigid3d& T_world_to);

// Gauss-Newton blocks of 0.5 * weight * e^T information e: H_ft = J_from^T information J_to and so
// on, b_f = J_from^T information e.
struct ConstraintBlocks {
  Matrix6d H_ff = Matrix6d::Zero(), H_ft = Matrix6d::Zero(), H_tt = Matrix6d::Zero();
  Vector6d b_f = Vector6d::Zero(), b_t = Vector6d::Zero();
};
ConstraintBlocks NormalBlocks(const PoseConstraint& constraint, double weight,
                              const Rigid3d& T_world_from, const Rigid3d& T_world_to);

// e^T information e.
double SquaredError(const PoseConstraint& constraint, const Rigid3d& T_world_from,
                    const Rigid3d& T_world_to);
// The same, given all poses of the graph.
double SquaredError(const PoseConstraint& constraint, const std::vector<Rigid3d>& T_world);

// Throws InputError naming the constraint (`what` and its two poses) if an index is outside
// 0 .. poses-1, if it links a pose to itself, or if its information is not finite, symmetric and
// positive definite.
void CheckConstraint(const PoseConstraint& constraint, int poses, const char* what);

}  // namespace tvl
