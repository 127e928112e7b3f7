#include "tvl/slam/slam_runner.h"

#include <future>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Fetches the next frame while one is worked on.
class Prefetcher {
 public:
  Prefetcher(FrameSource& source, bool in_background)
      : source_(source), in_background_(in_background) {}
  ~Prefetcher() {
    if (next_.valid()) next_.wait();
  }

  std::optional<SensorFrame> Next() {
    if (!in_background_) return source_.Next();
    std::optional<SensorFrame> frame = next_.valid() ? next_.get() : source_.Next();
    if (frame) next_ = std::async(std::launch::async, [this] { return source_.Next(); });
    return frame;
  }

 private:
  FrameSource& source_;
  bool in_background_;
  std::future<std::optional<SensorFrame>> next_;
};

// The system a run goes on with, and its results so far.
struct Started {
  SlamSystem system;
  std::vector<FrameResult> frames;
  DeskewDecision deskew;
  bool stopped = false;
  std::exception_ptr failure;
};

// Calls next_frame() until it says no; returns what it throws.
std::exception_ptr ForEachFrame(const std::function<bool()>& next_frame) {
  try {
    while (next_frame()) {
    }
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

Started StartWith(Deskew deskew, const std::string& said_by, const SensorSetup& setup,
                  const RunOptions& options) {
  return {SlamSystem(setup, deskew, options.slam, options.threads > 1),
          {},
          {deskew, DeskewVerdict::kGiven, said_by, {}, 0},
          false,
          nullptr};
}

Started StartWithTrial(Prefetcher& frames, const SensorSetup& setup, const RunOptions& options,
                       const RunObserver& observer, const Executor& executor) {
  DeskewTrial trial(setup, options.slam, options.decision, options.threads > 1);
  bool stopped = false;
  const std::exception_ptr failure = ForEachFrame([&] {
    if (stopped || trial.IsOver()) return false;
    const std::optional<SensorFrame> frame = frames.Next();
    if (frame) stopped = !observer(trial.ProcessFrame(*frame, executor));
    return frame.has_value();
  });
  const DeskewDecision decision = trial.Judge();
  DeskewTrial::Contender taken = trial.Take();
  return {std::move(taken.system), std::move(taken.frames), decision, stopped, failure};
}

Started Start(Prefetcher& frames, const SensorSetup& setup, const RunOptions& options,
              const RunObserver& observer, const Executor& executor) {
  if (options.deskew) return StartWith(*options.deskew, "set by the user", setup, options);
  if (setup.deskew) return StartWith(*setup.deskew, "stated by the input", setup, options);
  return StartWithTrial(frames, setup, options, observer, executor);
}

// What is to be said of the first frame of a run.
void CheckFirst(const FrameResult& first, const std::string& input) {
  for (const FrameFault& fault : first.faults) {
    TVL_CHECK_INPUT(fault.kind != FrameFault::Kind::kOddScan)
        << input << ": no usable scan to begin with: " << fault.message
        << "; is it the lidar of the profile (--profile)? If only this scan is odd begin later, "
        << "e.g. --frames " << first.id + 1 << ":";
  }
}

std::string FirstFaultOfScan(const std::vector<FrameResult>& frames) {
  for (const FrameResult& frame : frames) {
    if (const FrameFault* fault = FaultOfScan(frame.faults)) return ": " + fault->message;
  }
  return "";
}

}  // namespace

void RunOptions::Check() const {
  TVL_CHECK_INPUT(threads >= 1) << "threads: must be at least 1, is " << threads;
  slam.Check();
  decision.Check();
}

RunResult RunSlam(FrameSource& source, const RunOptions& options, const RunObserver& observer,
                  const GoOn& go_on) {
  options.Check();
  const Executor executor(options.threads);
  Prefetcher frames(source, options.threads > 1);
  bool is_first = true;
  const RunObserver checking_observer = [&](const FrameResult& frame) {
    if (is_first) CheckFirst(frame, source.setup().name);
    is_first = false;
    return observer(frame);
  };
  Started run = Start(frames, source.setup(), options, checking_observer, executor);
  RunResult result;
  result.deskew = run.deskew;
  result.frames = std::move(run.frames);
  result.stopped = run.stopped;
  result.failure = run.failure;
  if (!result.failure) {
    result.failure = ForEachFrame([&] {
      const std::optional<SensorFrame> frame = result.stopped ? std::nullopt : frames.Next();
      if (!frame) return false;
      result.frames.push_back(run.system.ProcessFrame(*frame, executor));
      result.stopped = !checking_observer(result.frames.back());
      return true;
    });
  }
  if (result.failure && run.system.map().keyframes.empty()) {
    std::rethrow_exception(result.failure);
  }
  result.stopped = result.stopped || result.failure;
  run.system.Finish([&go_on, stopped = result.stopped] { return !stopped && go_on(); });
  result.trajectory = run.system.trajectory();
  result.odometry = run.system.odometry_path();
  if (result.failure) {  // the frame that threw may have left its pose
    result.trajectory.resize(result.frames.size());
    result.odometry.resize(result.frames.size());
  }
  result.extrinsics = run.system.extrinsics();
  result.calibration = run.system.setup().calibration;
  result.loops = run.system.loops();
  result.stopped = result.stopped || result.loops.second_look_stopped;
  result.loop_fault = run.system.loop_fault();
  result.loop_search_broke = run.system.loop_search_broke();
  result.map = run.system.map();
  TVL_CHECK_INPUT(!result.map.keyframes.empty())
      << source.setup().name << ": no frame of " << result.frames.size() << " has a usable scan"
      << FirstFaultOfScan(result.frames);
  return result;
}

}  // namespace tvl
