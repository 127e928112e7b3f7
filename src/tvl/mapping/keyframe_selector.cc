#include "tvl/mapping/keyframe_selector.h"

#include "tvl/base/check.h"

namespace tvl {

void KeyframeOptions::Check() const {
  TVL_CHECK_INPUT(min_translation_m > 0.0) << "keyframes.min_translation_m: must be positive";
  TVL_CHECK_INPUT(min_rotation_rad > 0.0) << "keyframes.min_rotation_rad: must be positive";
  TVL_CHECK_INPUT(dense_share > 0.0 && dense_share <= 1.0)
      << "keyframes.dense_share: must be in (0, 1]";
}

bool IsKeyframe(const Rigid3d& T_lastkeyframe_cur, size_t keyframes,
                const KeyframeOptions& options) {
  if (keyframes == 0) return true;
  const double share =
      keyframes < static_cast<size_t>(options.dense_keyframes) ? options.dense_share : 1.0;
  return T_lastkeyframe_cur.t().norm() >= share * options.min_translation_m ||
         T_lastkeyframe_cur.RotationAngle() >= share * options.min_rotation_rad;
}

}  // namespace tvl
