#include "tvl/slam/slam_runner.h"

#include <deque>
#include <future>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// A source with frames put back at its front, and the next frame fetched while one is worked on.
class Prefetcher {
 public:
  Prefetcher(FrameSource& source, bool in_background)
      : source_(source), in_background_(in_background) {}
  ~Prefetcher() {
    if (next_.valid()) next_.wait();
  }

  std::optional<SensorFrame> Next() {
    if (!returned_.empty()) {
      SensorFrame frame = std::move(returned_.front());
      returned_.pop_front();
      return frame;
    }
    if (!in_background_) return source_.Next();
    std::optional<SensorFrame> frame = next_.valid() ? next_.get() : source_.Next();
    if (frame) next_ = std::async(std::launch::async, [this] { return source_.Next(); });
    return frame;
  }
  void PutBack(const std::vector<SensorFrame>& frames) {
    returned_.insert(returned_.begin(), frames.begin(), frames.end());
  }

 private:
  FrameSource& source_;
  bool in_background_;
  std::deque<SensorFrame> returned_;
  std::future<std::optional<SensorFrame>> next_;
};

DeskewDecision Decide(Prefetcher& frames, const SensorSetup& setup, const RunOptions& options,
                      const Executor& executor) {
  if (options.deskew) return {*options.deskew, DeskewVerdict::kGiven, "set by the user", {}, 0};
  if (setup.deskew) return {*setup.deskew, DeskewVerdict::kGiven, "stated by the input", {}, 0};
  std::vector<SensorFrame> first;
  while (first.size() < static_cast<size_t>(options.decision.max_frames)) {
    std::optional<SensorFrame> frame = frames.Next();
    if (!frame) break;
    first.push_back(std::move(*frame));
  }
  frames.PutBack(first);
  return DecideDeskew(first, setup, options.slam, options.decision, executor);
}

}  // namespace

void RunOptions::Check() const {
  TVL_CHECK_INPUT(threads >= 1) << "threads: must be at least 1, is " << threads;
  slam.Check();
  decision.Check();
}

RunResult RunSlam(FrameSource& source, const RunOptions& options, const RunObserver& observer) {
  options.Check();
  const Executor executor(options.threads);
  Prefetcher frames(source, options.threads > 1);
  RunResult result;
  result.deskew = Decide(frames, source.setup(), options, executor);
  SlamSystem system(source.setup(), result.deskew.deskew, options.slam);
  while (std::optional<SensorFrame> frame = frames.Next()) {
    result.frames.push_back(system.ProcessFrame(*frame, executor));
    if (!observer(result.frames.back())) {
      result.stopped = true;
      break;
    }
  }
  result.map = system.map();
  TVL_CHECK_INPUT(!result.map.keyframes.empty())
      << source.setup().name << ": no frame of " << result.frames.size() << " has a usable scan";
  return result;
}

}  // namespace tvl
