// Are the scans compensated, and if not, which way does the lidar spin? Both are stated wrongly
// often enough to let the data decide: the right answer fits the map better than the others. Where
// the first scan gives the time of each point, the spin need not be told: the answers are that the
// times are right (kClockwise stands for it) or that the scans are compensated all the same.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tvl/sensor/dataset.h"
#include "tvl/slam/slam_options.h"
#include "tvl/slam/slam_system.h"

namespace tvl {

enum class DeskewVerdict {
  kGiven,      // by the user or the input: nothing to decide
  kDecided,    // by the first frames
  kUndecided,  // the first frames do not tell: the input's default is taken
};
const char* ToString(DeskewVerdict verdict);
const char* ToString(Deskew deskew);  // none, cw, ccw

struct DeskewDecisionOptions {
  // Frames looked at, at most: 20 s, within which most drives turn.
  int max_frames = 200;
  // Driving straight all answers distort every scan alike and fit alike; in a turn they do not. A
  // frame tells something if the sensor turns by this much a sweep: 0.1 m at 20 m at its ends.
  double min_rotation_rad = 0.01;
  int min_informative = 20;  // such frames before a decision
  // The best answer's residual must be below each other's by this many standard
  // errors. Neighbouring frames share errors: 4 is not as much as it looks.
  double min_significance = 4.0;
  void Check() const;
};

struct DeskewDecision {
  Deskew deskew = Deskew::kNone;
  DeskewVerdict verdict = DeskewVerdict::kGiven;
  std::string reason;  // a sentence for the report
  // Typical squared scan-to-map residual of the informative frames (m^2; geometric mean of their
  // squared medians): none, cw, ccw. 0: not tried.
  std::array<double, 3> residual_sq_m2{};
  int informative = 0;
};

// A system for each answer, side by side, until the data decide. Whatever the verdict, the
// system and results of the answer taken are complete from the first frame on: nothing is run
// twice and no frame is kept.
class DeskewTrial {
 public:
  struct Contender {
    Deskew answer;
    SlamSystem system;
    std::vector<FrameResult> frames;
  };

  // `in_background`: see SlamSystem.
  DeskewTrial(const SensorSetup& setup, const SlamOptions& slam,
              const DeskewDecisionOptions& options, bool in_background = false);

  // Gives the frame to all; returns the result under the input's default answer (provisional).
  const FrameResult& ProcessFrame(const SensorFrame& frame, const Executor& executor);

  // Decided, or out of patience.
  bool IsOver() const;
  // The verdict so far.
  DeskewDecision Judge() const;
  // The contender that Judge() takes; the trial is over then.
  Contender Take();

 private:
  Contender& DefaultContender();
  void UsePointTimes();
  std::string TextOf(Deskew answer) const;

  DeskewDecisionOptions options_;
  Deskew default_answer_;
  std::vector<Contender> contenders_;
  bool has_seen_scan_ = false;
  bool has_point_times_ = false;  // the first scan had
  // Logarithms of the squared median residuals (m^2) of the informative frames, one list a
  // contender.
  std::vector<std::vector<double>> log_residuals_sq_;
};

}  // namespace tvl
