// When a frame becomes a keyframe (paper 6.1).
#pragma once

#include "tvl/geometry/rigid3.h"

namespace tvl {

struct KeyframeOptions {
  double min_translation_m = 1.0;
  double min_rotation_rad = 0.2;
  // A map of few scans has gaps: until it holds this many keyframes, this share of the thresholds
  // is enough.
  int dense_keyframes = 10;
  double dense_share = 0.3;
  void Check() const;
};

// `keyframes` is the number there are. True for the first frame.
bool IsKeyframe(const Rigid3d& T_lastkeyframe_cur, size_t keyframes,
                const KeyframeOptions& options);

}  // namespace tvl
