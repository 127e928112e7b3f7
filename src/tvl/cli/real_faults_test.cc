// A real street with faults made into its frames: stamps that lie, lost, repeated and missing
// scans. The run without faults is the reference: what is tested is that faults do not change the
// result.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/cli/input.h"
#include "tvl/io/test_data.h"
#include "tvl/slam/slam_system.h"

namespace tvl {
namespace {

// A frame as it is delivered: which of the recording, and with which stamp.
struct Delivery {
  size_t physical = 0;
  double stamp_s = 0.0;
};

struct Played {
  std::vector<Delivery> deliveries;
  std::vector<FrameStatus> status;
  Trajectory trajectory;
};

std::vector<Delivery> AsRecorded(size_t frames) {
  std::vector<Delivery> deliveries;
  for (size_t k = 0; k < frames; ++k) deliveries.push_back({k, 0.1 * static_cast<double>(k)});
  return deliveries;
}

std::vector<Delivery> Without(size_t first, size_t count, size_t frames, bool renumbered) {
  std::vector<Delivery> deliveries = AsRecorded(frames);
  const auto begin = deliveries.begin() + static_cast<std::ptrdiff_t>(first);
  deliveries.erase(begin, begin + static_cast<std::ptrdiff_t>(count));
  for (size_t i = 0; renumbered && i < deliveries.size(); ++i) {
    deliveries[i].stamp_s = 0.1 * static_cast<double>(i);
  }
  return deliveries;
}

class RealFaults : public ::testing::TestWithParam<Deskew> {
 protected:
  void SetUp() override {
    const auto folder = TestDataPath("sequences/kitti360_3000");
    if (!folder) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real recordings";
    data_ = OpenInput(*folder);
    clean_ = Play(AsRecorded(data_->size()));
  }

  Played Play(const std::vector<Delivery>& deliveries) const {
    const Executor executor(2);
    SlamOptions options;
    options.use_camera = false;
    options.loops.enabled = false;
    SlamSystem system(data_->setup(), GetParam(), options);
    Played played{deliveries, {}, {}};
    for (size_t i = 0; i < deliveries.size(); ++i) {
      SensorFrame frame = data_->Frame(deliveries[i].physical);
      frame.id = static_cast<FrameId>(i);
      frame.stamp = Timestamp::FromSeconds(50.0 + deliveries[i].stamp_s);
      played.status.push_back(system.ProcessFrame(frame, executor).status);
    }
    played.trajectory = system.trajectory();
    return played;
  }

  // Every frame that claims to be measured is where the clean run has it, and the last one is.
  void ExpectAsClean(const Played& played, double max_error_m) const {
    for (size_t i = 0; i < played.status.size(); ++i) {
      if (!IsMeasured(played.status[i])) continue;
      const Rigid3d error =
          clean_.trajectory[played.deliveries[i].physical].T_world_lidar.Inverse() *
          played.trajectory[i].T_world_lidar;
      EXPECT_LT(error.t().norm(), max_error_m) << "frame " << i;
      EXPECT_LT(RadToDeg(error.RotationAngle()), 1.0) << "frame " << i;
    }
    EXPECT_TRUE(IsMeasured(played.status.back()));
  }

  std::unique_ptr<Dataset> data_;
  Played clean_;
};

TEST_P(RealFaults, StampsThatLieCostNothing) {
  const size_t frames = data_->size();
  Rng rng(2);
  const std::vector<std::pair<const char*, std::function<double(size_t, double)>>> changes = {
      {"one 80 ms late", [](size_t k, double s) { return k == 20 ? s + 0.08 : s; }},
      {"one 98 ms late", [](size_t k, double s) { return k == 20 ? s + 0.098 : s; }},
      {"sigma 20 ms", [&](size_t, double s) { return s + 0.02 * rng.Normal(); }},
      {"clock set on by 5 s", [](size_t k, double s) { return k < 20 ? s : s + 5.0; }}};
  for (const auto& [name, change] : changes) {
    SCOPED_TRACE(name);
    std::vector<Delivery> deliveries = AsRecorded(frames);
    for (size_t k = 0; k < frames; ++k) deliveries[k].stamp_s = change(k, deliveries[k].stamp_s);
    ExpectAsClean(Play(deliveries), 0.15);
  }
}

TEST_P(RealFaults, LostScansAreFoundOut) {
  for (const size_t lost : {2u, 3u}) {
    for (const bool renumbered : {false, true}) {
      SCOPED_TRACE(testing::Message() << lost << (renumbered ? " lost, renumbered" : " lost"));
      ExpectAsClean(Play(Without(20, lost, data_->size(), renumbered)), 0.25);
    }
  }
}

TEST_P(RealFaults, RepeatedScansAreLeftOut) {
  std::vector<Delivery> twice;
  for (size_t k = 0; k < 2 * data_->size(); ++k) {
    twice.push_back({k / 2, 0.1 * static_cast<double>(k)});
  }
  ExpectAsClean(Play(twice), 0.25);
}

INSTANTIATE_TEST_SUITE_P(AsStoredAndDeskewed, RealFaults,
                         ::testing::Values(Deskew::kNone, Deskew::kClockwise));

// 13 m/s from the first scan on, without a camera: the first motion is the hardest.
class RealStart : public ::testing::TestWithParam<Deskew> {};

TEST_P(RealStart, EveryStepIsRight) {
  const auto folder = TestDataPath("sequences/kitti_2011_09_26_0013_first16");
  if (!folder) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real recordings";
  const auto data = OpenInput(*folder);
  const std::vector<Rigid3d> T_true = data->Truth_T_first_cam0();
  ASSERT_EQ(T_true.size(), data->size());
  SlamOptions options;
  options.use_camera = false;
  options.loops.enabled = false;
  SlamSystem system(data->setup(), GetParam(), options);
  const Executor executor(2);
  for (size_t i = 0; i < data->size(); ++i) {
    EXPECT_TRUE(IsMeasured(system.ProcessFrame(data->Frame(i), executor).status)) << i;
  }
  const Trajectory trajectory = system.trajectory();
  const Rigid3d& T_cam0_lidar = data->setup().calibration.T_cam0_lidar;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    const Rigid3d step = T_cam0_lidar * trajectory[i - 1].T_world_lidar.Inverse() *
                         trajectory[i].T_world_lidar * T_cam0_lidar.Inverse();
    const Rigid3d T_true_step = T_true[i - 1].Inverse() * T_true[i];
    EXPECT_LT((step.t() - T_true_step.t()).norm(), 0.15) << "frame " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(AnyDeskewing, RealStart,
                         ::testing::Values(Deskew::kNone, Deskew::kClockwise,
                                           Deskew::kCounterClockwise));

}  // namespace
}  // namespace tvl
