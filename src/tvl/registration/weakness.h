// Which directions the data holds weakly, and which sensor holds them (design: degeneracy).
//
// Rotation and translation are judged in separate 3x3 blocks, each with the other marginalised
// out: eigenvalues of a 6x6 of mixed units mean nothing. The information that noisy plane normals
// leak into every direction is subtracted first, else a tunnel's axis looks held.
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

struct Weakness {
  std::vector<WeakDirection> directions;  // weaker than `held`
  // Applied to the laser's Jacobian, J M: what is left of the lidar's say. Identity if all is held.
  Matrix6d lidar_mask = Matrix6d::Identity();
  // Relative strengths of the lidar's weakest translation and rotation, 0..1: for histograms.
  double translation_ratio = 1.0, rotation_ratio = 1.0;
};

Weakness AnalyseWeakness(const LaserSum& laser, const NormalEquations& visual,
                         const WeaknessOptions& options);

// Normal equations of the laser with its Jacobian masked.
NormalEquations Masked(const NormalEquations& laser, const Matrix6d& mask);

}  // namespace tvl
