// Section 6 of the paper in one place: a keyframe in, corrected poses of all keyframes out.
#pragma once

#include <functional>
#include <memory>

#include "tvl/map/keyframe_store.h"
#include "tvl/sensor/calibration.h"
#include "tvl/slam/loop_options.h"
#include "tvl/slam/loop_types.h"

namespace tvl {

// Not thread-safe: one call at a time, from any thread.
class LoopCloser {
 public:
  // Throws InputError for unusable options or vocabulary.
  LoopCloser(const LoopOptions& options, const Calibration& calibration,
             std::shared_ptr<const KeyframeStore> store);
  ~LoopCloser();

  // Keyframes in the order they were made; the store must have their payloads from the next one on.
  // Their T_world_lidar is not read.
  LoopUpdate Process(const Keyframe& keyframe, const KeyframePayload& payload);
  // At the end of the data: looks once more at all keyframes without a loop, as long as `go_on`,
  // asked before each of them, says yes ...
  LoopUpdate LookAgain(const std::function<bool()>& go_on = [] { return true; });
  // ... and solves the whole graph as one, dropping loops that the others contradict.
  LoopUpdate Polish();

  const LoopReport& report() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tvl
