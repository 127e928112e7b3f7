// Which directions the data holds weakly, and which sensor holds them (design: degeneracy).
//
// Rotation and translation are judged in separate 3x3 blocks, each with the other marginalised
// out: eigenvalues of a 6x6 of mixed units mean nothing. The information that noisy plane normals
// leak into every direction is subtracted first, else a tunnel's axis looks held.
//
// A weak direction does not change the laser's residuals: its measurement is taken to carry an
// unknown shift along it, which is estimated beside the pose (LaserShift).
#pragma once

#include <vector>

#include "tvl/frame/motion_estimate.h"
#include "tvl/registration/laser_terms.h"

namespace tvl {

struct WeaknessOptions {
  // Error of a plane's normal, rad: 2 degrees, from 2-4 cm noise over a 1 m patch.
  double normal_sigma_rad = 0.035;
  // Weakest to strongest information of a block (leak subtracted). Below `weak` the lidar has no
  // say in the direction, above `held` it has its full one; between them it fades.
  double weak_translation = 0.008, held_translation = 0.016;
  // A road 4 m wide holds the roll of a 40 m tube with a ratio of 0.002, and well enough.
  double weak_rotation = 0.0003, held_rotation = 0.001;
  void Check() const;
};

// An unknown additive shift of what the laser measures: it sees the pose T Exp(axes a) where the
// pose is T, and 0.5 a' diag(information) a is added to the cost. A direction with say s gets the
// information s / (1 - s) lambda, where lambda is the laser's information in it with everything
// else marginalised out. Eliminating a then leaves s lambda of it: the covariance of the laser's
// measurement grows by (1 - s) / (s lambda) along the axis and nowhere else, so the other block's
// marginal stays what it is. s = 0 leaves nothing; the problem is one function for every s.
struct LaserShift {
  // Eigenvectors of both blocks as columns: 0..2 rotation, 3..5 translation.
  Matrix6d axes = Matrix6d::Identity();
  Vector6d information = Vector6d::Zero();  // of a; 1/rad^2, 1/m^2
  Vector6d is_free = Vector6d::Zero();      // 1 in weak directions; elsewhere 0, and a is 0

  bool any() const { return is_free.any(); }
};

struct Weakness {
  std::vector<WeakDirection> directions;  // weaker than `held`
  LaserShift shift;                       // the same, for the solver
  // Relative strengths of the lidar's weakest translation and rotation, 0..1: for histograms.
  double translation_ratio = 1.0, rotation_ratio = 1.0;
};

Weakness AnalyseWeakness(const LaserSum& laser, const NormalEquations& visual,
                         const WeaknessOptions& options);

// The shift that leaves the laser `say` (0..1, one for each column) of its information along
// `axes`, with eigenvalues `lambda` of the laser's marginal blocks; say = 1: no shift.
LaserShift MakeLaserShift(const Matrix6d& axes, const Vector6d& lambda, const Vector6d& say);

// Where the laser sees the pose.
Rigid3d ShiftedByLaser(const ShiftedPose& pose, const LaserShift& shift);

// Equations of pose and shift from those of the laser at ShiftedByLaser(pose, shift).
ShiftedEquations WithShift(const NormalEquations& laser, const ShiftedPose& pose,
                           const LaserShift& shift);

}  // namespace tvl
