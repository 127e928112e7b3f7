// Section 6 of the paper in one place: a keyframe in, corrected poses of all keyframes out.
#pragma once

#include <memory>

#include "tvl/map/keyframe_store.h"
#include "tvl/sensor/calibration.h"
#include "tvl/slam/loop_types.h"

namespace tvl {

struct LoopOptions {
  bool enabled = true;
  // What was found for a keyframe is applied when so many more have been made, whether it was found
  // at once or just in time: results must not depend on the machine. 10 m at walking pace or
  // motorway speed are 0.3 s and more.
  int lag_keyframes = 10;
  void Check() const;
};

class LoopCloser {
 public:
  LoopCloser(const LoopOptions& options, const Calibration& calibration,
             std::shared_ptr<const KeyframeStore> store);
  ~LoopCloser();

  // Keyframes in the order they were made.
  LoopUpdate Process(const LoopJob& job);
  // At the end of the data: looks once more, and polishes.
  LoopUpdate Finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tvl
