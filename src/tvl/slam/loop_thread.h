// Runs loop closing beside the odometry, one keyframe after the other. What it found is handed out
// by keyframe, so that results do not depend on when it was found.
#pragma once

#include <functional>
#include <memory>

#include "tvl/slam/loop_types.h"

namespace tvl {

class LoopThread {
 public:
  using Work = std::function<LoopUpdate()>;

  // Without a background thread work is done when it is given.
  explicit LoopThread(bool in_background);
  ~LoopThread();  // waits for the work that has begun; the rest is dropped
  LoopThread(LoopThread&&) noexcept;
  LoopThread& operator=(LoopThread&&) noexcept;

  void Give(Work work);
  // Results not taken yet.
  size_t pending() const;
  // The oldest result not taken yet; waits for it. Throws what the work threw.
  LoopUpdate Take();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tvl
