#include "tvl/slam/loop_closer.h"

#include "tvl/base/check.h"

namespace tvl {

void LoopOptions::Check() const {
  TVL_CHECK_INPUT(lag_keyframes >= 0) << "loops.lag_keyframes: must not be negative";
}

struct LoopCloser::Impl {
  LoopOptions options;
  std::shared_ptr<const KeyframeStore> store;
  std::vector<Rigid3d> T_world;
};

LoopCloser::LoopCloser(const LoopOptions& options, const Calibration&,
                       std::shared_ptr<const KeyframeStore> store)
    : impl_(std::make_unique<Impl>()) {
  options.Check();
  impl_->options = options;
  impl_->store = std::move(store);
}
LoopCloser::~LoopCloser() = default;

LoopUpdate LoopCloser::Process(const LoopJob& job) {
  auto& poses = impl_->T_world;
  poses.push_back(poses.empty() ? job.keyframe.T_odom_lidar : poses.back() * job.T_prev_cur);
  LoopUpdate update;
  update.last = static_cast<int>(poses.size()) - 1;
  update.T_world_last = poses.back();
  return update;
}

LoopUpdate LoopCloser::Finish() {
  LoopUpdate update;
  update.last = static_cast<int>(impl_->T_world.size()) - 1;
  update.T_world_lidar = impl_->T_world;
  if (update.last >= 0) update.T_world_last = impl_->T_world.back();
  return update;
}

}  // namespace tvl
