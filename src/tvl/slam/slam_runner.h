// Runs the system over a stream of frames: the only place with threads and queues. Results do not
// depend on the number of threads.
#pragma once

#include <exception>
#include <functional>
#include <optional>

#include "tvl/slam/deskew_decision.h"
#include "tvl/slam/slam_system.h"

namespace tvl {

struct RunOptions {
  SlamOptions slam;
  int threads = 1;
  // Empty: what the input says of itself, else decided from the first frames, else its default.
  std::optional<Deskew> deskew;
  DeskewDecisionOptions decision;
  void Check() const;
};

struct RunResult {
  std::vector<FrameResult> frames;  // one a frame of the input, in order, as known at the time
  Trajectory trajectory;            // of the same frames, with all loops
  Map map;
  LoopReport loops;
  std::string loop_fault;          // why the loop search ended before its time; empty: it did not
  bool loop_search_broke = false;  // that was a defect of the program
  OdometryPath odometry;           // of the same frames, before loops correct it
  DeskewDecision deskew;
  ExtrinsicEstimate extrinsics;  // against those of the input, or those that fit corrected points
  Calibration calibration;       // as used at the end
  bool stopped = false;          // the observer or `go_on` said so, or `failure`
  // What ended the run at a frame after the first keyframe: the results are complete up to there,
  // and it is to be thrown again once they are safe. Null: nothing did.
  std::exception_ptr failure;
};

// Sees every frame's result, once and in order; returns false to stop the run (all results so far
// are kept, and its end is not held up by a second look for loops). Until the de-skewing is decided
// it sees the results under the input's default.
using RunObserver = std::function<bool(const FrameResult&)>;

// What is thrown by the source, a frame or the observer ends the run: see RunResult::failure.
// Without a keyframe it is thrown at once. Throws InputError if not one frame has a usable scan, or
// at once if the first frame's scan is one whose rings cannot be told: the others will hardly be
// better. `go_on` is asked during the second look for loops.
RunResult RunSlam(
    FrameSource& source, const RunOptions& options, const RunObserver& observer,
    const GoOn& go_on = [] { return true; });

}  // namespace tvl
