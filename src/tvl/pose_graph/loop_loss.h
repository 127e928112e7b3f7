// How much a loop is believed, given how far the other measurements are from it.
#pragma once

#include <algorithm>

#include "tvl/geometry/robust.h"

namespace tvl {

enum class LoopLoss {
  kNone,   // every loop is true
  kHuber,  // quadratic up to the width, then linear: false loops are weakened, never dropped
  kDcs,  // dynamic covariance scaling (Agarwal et al. 2013): switchable constraints in closed form
  kGnc,  // truncated least squares: a loop beyond the width counts for nothing
};

// `width_sq` is the squared whitened error (chi-square of 6) beyond which a loop is doubted.
// rho and the weight d rho / d e_sq of the loss itself; kGnc: of its last, truncated form.
inline RobustValue EvaluateLoopLoss(LoopLoss loss, double e_sq, double width_sq) {
  switch (loss) {
    case LoopLoss::kNone:
      break;
    case LoopLoss::kHuber:
      return Huber(e_sq, std::sqrt(width_sq));
    case LoopLoss::kDcs: {
      if (e_sq <= width_sq) return {e_sq, 1.0};
      const double s = 2.0 * width_sq / (width_sq + e_sq);
      return {width_sq * (3.0 * e_sq - width_sq) / (e_sq + width_sq), s * s};
    }
    case LoopLoss::kGnc:
      return e_sq <= width_sq ? RobustValue{e_sq, 1.0} : RobustValue{width_sq, 0.0};
  }
  return {e_sq, 1.0};
}

}  // namespace tvl
