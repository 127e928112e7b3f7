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
};

Started StartWith(Deskew deskew, const std::string& said_by, const SensorSetup& setup,
                  const RunOptions& options) {
  return {SlamSystem(setup, deskew, options.slam, options.threads > 1),
          {},
          {deskew, DeskewVerdict::kGiven, said_by, {}, 0}};
}

Started StartWithTrial(Prefetcher& frames, const SensorSetup& setup, const RunOptions& options,
                       const RunObserver& observer, const Executor& executor) {
  DeskewTrial trial(setup, options.slam, options.decision, options.threads > 1);
  bool go_on = true;
  while (go_on && !trial.IsOver()) {
    const std::optional<SensorFrame> frame = frames.Next();
    if (!frame) break;
    go_on = observer(trial.ProcessFrame(*frame, executor));
  }
  const DeskewDecision decision = trial.Judge();
  DeskewTrial::Contender taken = trial.Take();
  return {std::move(taken.system), std::move(taken.frames), decision, !go_on};
}

Started Start(Prefetcher& frames, const SensorSetup& setup, const RunOptions& options,
              const RunObserver& observer, const Executor& executor) {
  if (options.deskew) return StartWith(*options.deskew, "set by the user", setup, options);
  if (setup.deskew) return StartWith(*setup.deskew, "stated by the input", setup, options);
  return StartWithTrial(frames, setup, options, observer, executor);
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
  Started run = Start(frames, source.setup(), options, observer, executor);
  RunResult result;
  result.deskew = run.deskew;
  result.frames = std::move(run.frames);
  result.stopped = run.stopped;
  while (!result.stopped) {
    const std::optional<SensorFrame> frame = frames.Next();
    if (!frame) break;
    result.frames.push_back(run.system.ProcessFrame(*frame, executor));
    result.stopped = !checking_observer(result.frames.back());
  }
  run.system.Finish([&go_on, stopped = result.stopped] { return !stopped && go_on(); });
  result.trajectory = run.system.trajectory();
  result.odometry = run.system.odometry_path();
  result.loops = run.system.loops();
  result.loop_fault = run.system.loop_fault();
  result.map = run.system.map();
  TVL_CHECK_INPUT(!result.map.keyframes.empty())
      << source.setup().name << ": no frame of " << result.frames.size() << " has a usable scan";
  return result;
}

}  // namespace tvl
  result.loop_search_broke = run.system.loop_search_broke();
  result.stopped = result.stopped || result.loops.second_look_stopped;
