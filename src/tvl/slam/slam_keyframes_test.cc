// What a keyframe keeps.
#include <gtest/gtest.h>

#include "tvl/slam/slam_system.h"
#include "tvl/slam/test_drive.h"

namespace tvl {
namespace {

using synthetic::Drive;
using synthetic::DriveOptions;

DriveOptions Options(size_t frames, bool camera) {
  DriveOptions options;
  options.frames = frames;
  options.camera = camera;
  return options;
}

// The search for old passes asks by time, which must not run back.
TEST(KeyframeOf, AClockThatRestartsHasStampsThatNeverDecrease) {
  const Drive drive(Options(14, false));
  SlamOptions options;
  options.use_camera = false;
  SlamSystem system(drive.setup(), Deskew::kNone, options);
  for (size_t i = 0; i < drive.size(); ++i) {
    SensorFrame frame = drive.Frame(i);
    if (i >= 7) frame.stamp = drive.Frame(i - 7).stamp;
    system.ProcessFrame(frame, Executor(1));
  }
  const std::vector<Keyframe>& keyframes = system.map().keyframes;
  ASSERT_GE(keyframes.size(), 8u);
  EXPECT_EQ(keyframes[1].stamp, drive.Frame(static_cast<size_t>(keyframes[1].frame)).stamp);
  for (size_t i = 1; i < keyframes.size(); ++i) {
    const auto frames = static_cast<double>(keyframes[i].frame - keyframes[i - 1].frame);
    EXPECT_NEAR(SecondsBetween(keyframes[i - 1].stamp, keyframes[i].stamp), 0.1 * frames, 1e-6);
  }
}

size_t ImageFeaturesOf(const Drive& drive, const SlamOptions& options) {
  SlamSystem system(drive.setup(), Deskew::kNone, options);
  for (size_t i = 0; i < drive.size(); ++i) system.ProcessFrame(drive.Frame(i), Executor(1));
  return system.map().store->Image(0)->size();
}

TEST(KeyframeOf, ImagesAreDescribedForTheVisualSearchAlone) {
  const Drive drive(Options(2, true));
  SlamOptions options;
  EXPECT_GT(ImageFeaturesOf(drive, options), 50u);
  options.loops.use_visual = false;
  EXPECT_EQ(ImageFeaturesOf(drive, options), 0u);
  options.loops.use_visual = true;
  options.loops.enabled = false;
  EXPECT_EQ(ImageFeaturesOf(drive, options), 0u);
}

}  // namespace
}  // namespace tvl
