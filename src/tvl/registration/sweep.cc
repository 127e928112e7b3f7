#include "tvl/registration/sweep.h"

#include <algorithm>
#include <cmath>

namespace tvl {

int SweepBins::BinOf(double time_offset_s, double period_s) const {
  if (bins == 1) return 0;
  const double share = 0.5 + time_offset_s / period_s;
  return std::clamp(static_cast<int>(std::floor(share * bins)), 0, bins - 1);
}

SweepMotion::SweepMotion(const SweepBins& sweep, const Rigid3d& T_k_k1) {
  bins.resize(static_cast<size_t>(sweep.bins));
  if (sweep.bins == 1) {
    bins[0] = {T_k_k1.R(), T_k_k1.t(), Matrix6d::Identity()};
    return;
  }
  const Vector6d xi = T_k_k1.Log();
  const Matrix6d Jr_inverse = RightJacobianInverseSe3(xi);
  for (int i = 0; i < sweep.bins; ++i) {
    const double s = sweep.Share(i);
    const Rigid3d T = Rigid3d::Exp(s * xi);
    bins[static_cast<size_t>(i)] = {T.R(), T.t(), s * RightJacobianSe3(s * xi) * Jr_inverse};
  }
}

}  // namespace tvl
