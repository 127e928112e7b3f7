#include "tvl/eval/kitti_metric.h"

#include "tvl/base/check.h"
#include "tvl/eval/path_length.h"
#include "tvl/eval/relative_error.h"

namespace tvl {

std::vector<SegmentError> KittiSegmentErrors(const std::vector<Rigid3d>& truth,
                                             const std::vector<Rigid3d>& estimate) {
  TVL_CHECK(truth.size() == estimate.size()) << truth.size() << ", " << estimate.size();
  const std::vector<double> lengths_m = PathLengths(truth);
  std::vector<SegmentError> segments;
  for (size_t first = 0; first < truth.size(); first += kKittiStep_frames) {
    for (const double length_m : kKittiLengths_m) {
      const auto last = IndexAfter(lengths_m, first, length_m);
      if (!last) break;  // longer ones end later still
      const MotionError error =
          ErrorOfMotion(truth[first], truth[*last], estimate[first], estimate[*last]);
      segments.push_back(
          {first, *last, length_m, error.translation_m / length_m, error.rotation_deg / length_m});
    }
  }
  return segments;
}

KittiError MeanError(const std::vector<SegmentError>& segments) {
  KittiError mean;
  mean.segments = segments.size();
  for (const SegmentError& segment : segments) {
    mean.t_err_percent += 100.0 * segment.t_err_m_per_m / static_cast<double>(segments.size());
    mean.r_err_deg_per_m += segment.r_err_deg_per_m / static_cast<double>(segments.size());
  }
  return mean;
}

std::array<KittiError, kKittiLengths_m.size()> MeanErrorByLength(
    const std::vector<SegmentError>& segments) {
  std::array<KittiError, kKittiLengths_m.size()> means;
  for (size_t i = 0; i < means.size(); ++i) {
    std::vector<SegmentError> of_length;
    for (const SegmentError& segment : segments) {
      if (segment.length_m == kKittiLengths_m[i]) of_length.push_back(segment);
    }
    means[i] = MeanError(of_length);
  }
  return means;
}

}  // namespace tvl
