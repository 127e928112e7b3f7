// Distance of a motion from a predicted one.
#pragma once

#include "tvl/factors/residual.h"

namespace tvl {

// r = Log(T_prior^-1 T), [rotation rad, translation m].
inline Residual<6> EvaluatePosePrior(const Rigid3d& T_prior, const Rigid3d& T) {
  Residual<6> out;
  out.r = (T_prior.Inverse() * T).Log();
  out.J = RightJacobianInverseSe3(out.r);
  return out;
}

}  // namespace tvl
