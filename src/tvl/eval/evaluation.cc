#include "tvl/eval/evaluation.h"

#include "tvl/base/check.h"
#include "tvl/eval/path_length.h"

namespace tvl {

DriveEvaluation EvaluateDrive(const std::string& name, const std::vector<Rigid3d>& truth,
                              const std::vector<Rigid3d>& estimate) {
  TVL_CHECK_INPUT(truth.size() == estimate.size())
      << name << ": " << estimate.size() << " estimated poses, " << truth.size() << " true ones";
  TVL_CHECK_INPUT(truth.size() >= 2) << name << ": a single pose cannot be evaluated";
  DriveEvaluation drive;
  drive.name = name;
  drive.frames = truth.size();
  drive.truth_length_m = PathLengths(truth).back();
  drive.estimate_length_m = PathLengths(estimate).back();
  drive.segments = KittiSegmentErrors(truth, estimate);
  drive.kitti = MeanError(drive.segments);
  drive.kitti_by_length = MeanErrorByLength(drive.segments);
  drive.ate = SummariseErrors(PositionErrors_m(truth, estimate, AlignPositions(truth, estimate)));
  drive.ate_first_pose =
      SummariseErrors(PositionErrors_m(truth, estimate, AlignFirstPose(truth, estimate)));
  drive.rpe_frame = RelativeErrorPerFrame(truth, estimate);
  drive.rpe_10m = RelativeErrorPerDistance(truth, estimate, 10.0);
  drive.rpe_100m = RelativeErrorPerDistance(truth, estimate, 100.0);
  drive.total = ErrorOfMotion(truth.front(), truth.back(), estimate.front(), estimate.back());
  return drive;
}

Evaluation Combine(std::vector<DriveEvaluation> drives) {
  Evaluation evaluation;
  std::vector<SegmentError> segments;
  size_t long_enough = 0;
  for (const DriveEvaluation& drive : drives) {
    segments.insert(segments.end(), drive.segments.begin(), drive.segments.end());
    if (drive.kitti.segments == 0) continue;
    ++long_enough;
    evaluation.drive_mean.segments += drive.kitti.segments;
    evaluation.drive_mean.t_err_percent += drive.kitti.t_err_percent;
    evaluation.drive_mean.r_err_deg_per_m += drive.kitti.r_err_deg_per_m;
  }
  if (long_enough > 0) {
    evaluation.drive_mean.t_err_percent /= static_cast<double>(long_enough);
    evaluation.drive_mean.r_err_deg_per_m /= static_cast<double>(long_enough);
  }
  evaluation.segment_mean = MeanError(segments);
  evaluation.drives = std::move(drives);
  return evaluation;
}

}  // namespace tvl
