#include "tvl/mapping/keyframe_selector.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr size_t kMany = 50;

Rigid3d Turned(double angle_rad) {
  return {ExpSo3(angle_rad * Eigen::Vector3d::UnitZ()), Eigen::Vector3d::Zero()};
}

TEST(IsKeyframe, TheFirstFrameAlways) {
  EXPECT_TRUE(IsKeyframe(Rigid3d(), 0, KeyframeOptions()));
  EXPECT_FALSE(IsKeyframe(Rigid3d(), 1, KeyframeOptions()));
}

TEST(IsKeyframe, AfterTheWayOrTheTurn) {
  const KeyframeOptions options;
  const double way_m = options.min_translation_m, turn_rad = options.min_rotation_rad;
  EXPECT_FALSE(IsKeyframe(Rigid3d::Translation(0.9 * way_m, 0, 0), kMany, options));
  EXPECT_TRUE(IsKeyframe(Rigid3d::Translation(0, -1.1 * way_m, 0), kMany, options));
  EXPECT_FALSE(IsKeyframe(Turned(0.9 * turn_rad), kMany, options));
  EXPECT_TRUE(IsKeyframe(Turned(-1.1 * turn_rad), kMany, options));
}

TEST(IsKeyframe, MoreOftenWhileTheMapIsYoung) {
  KeyframeOptions options;
  options.dense_keyframes = 10;
  options.dense_share = 0.3;
  const Rigid3d step = Rigid3d::Translation(0.4 * options.min_translation_m, 0, 0);
  EXPECT_TRUE(IsKeyframe(step, 9, options));
  EXPECT_FALSE(IsKeyframe(step, 10, options));
}

TEST(KeyframeOptions, NameTheBadField) {
  KeyframeOptions options;
  options.min_rotation_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
