// Are the scans compensated, and if not, which way does the lidar spin? Both are stated wrongly
// often enough to let the data decide: the right answer fits the map better than the others.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tvl/sensor/dataset.h"
#include "tvl/slam/slam_options.h"

namespace tvl {

enum class DeskewVerdict {
  kGiven,      // by the user or the input: nothing to decide
  kDecided,    // by the first frames
  kUndecided,  // the first frames do not tell: the input's default is taken
};
const char* ToString(DeskewVerdict verdict);
const char* ToString(Deskew deskew);  // none, cw, ccw

struct DeskewDecisionOptions {
  int max_frames = 30;      // looked at, at most
  int min_informative = 8;  // frames that must tell the answers apart
  // A frame tells something if a point at the end of the sweep moves by more than this against its
  // middle: half a step, or half a turn's angle at 20 m.
  double min_shift_m = 0.15;
  // The best answer's mean residual must be below the second's by this many standard errors.
  double min_significance = 4.0;
  void Check() const;
};

struct DeskewDecision {
  Deskew deskew = Deskew::kNone;
  DeskewVerdict verdict = DeskewVerdict::kGiven;
  std::string reason;  // a sentence for the report
  // Mean squared scan-to-map residual over the informative frames (m^2): none, cw, ccw.
  std::array<double, 3> residual_sq_m2{};
  int informative = 0;
};

// Runs a lidar-only system over the frames with each answer.
DeskewDecision DecideDeskew(const std::vector<SensorFrame>& frames, const SensorSetup& setup,
                            const SlamOptions& slam, const DeskewDecisionOptions& options,
                            const Executor& executor);

}  // namespace tvl
