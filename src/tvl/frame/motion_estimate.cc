#include "tvl/frame/motion_estimate.h"

namespace tvl {

const char* ToString(EstimateStatus status) {
  switch (status) {
    case EstimateStatus::kFirst:
      return "first";
    case EstimateStatus::kConverged:
      return "converged";
    case EstimateStatus::kNotConverged:
      return "not_converged";
    case EstimateStatus::kPredicted:
      return "predicted";
  }
  return "unknown";
}

}  // namespace tvl
