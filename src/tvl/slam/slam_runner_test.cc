#include "tvl/slam/slam_runner.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/slam/test_drive.h"

namespace tvl {
namespace {

using synthetic::Drive;
using synthetic::DriveOptions;

bool SeeAll(const FrameResult&) { return true; }

DriveOptions Frames(size_t frames, Deskew spin = Deskew::kNone) {
  DriveOptions options;
  options.frames = frames;
  options.spin = spin;
  return options;
}

RunOptions LidarOnly() {
  RunOptions options;
  options.slam.use_camera = false;
  return options;
}

RunResult Play(const Drive& drive, const RunOptions& options,
               const RunObserver& observer = SeeAll) {
  DatasetSource source(drive);
  return RunSlam(source, options, observer);
}

TEST(RunSlam, GivesOneResultAFrameInOrder) {
  const Drive drive(Frames(6));
  for (const int threads : {1, 2}) {
    RunOptions options = LidarOnly();
    options.threads = threads;
    options.deskew = Deskew::kNone;
    size_t seen = 0;
    const RunResult result = Play(drive, options, [&](const FrameResult& frame) {
      EXPECT_EQ(frame.id, static_cast<FrameId>(seen));
      ++seen;
      return true;
    });
    EXPECT_EQ(seen, 6u);
    EXPECT_EQ(result.frames.size(), 6u);
    EXPECT_FALSE(result.stopped);
    EXPECT_FALSE(result.map.keyframes.empty());
  }
}

TEST(RunSlam, TheObserverCanStopItAndResultsAreKept) {
  const Drive drive(Frames(30));
  for (const int threads : {1, 2}) {
    RunOptions options = LidarOnly();
    options.threads = threads;
    options.deskew = Deskew::kNone;
    const RunResult result =
        Play(drive, options, [](const FrameResult& frame) { return frame.id < 4; });
    EXPECT_TRUE(result.stopped);
    EXPECT_EQ(result.frames.size(), 5u);
    EXPECT_FALSE(result.map.keyframes.empty());
  }
}

// The second look takes long; whoever stops a run wants its results now.
TEST(RunSlam, StoppedItDoesNotLookAgainForLoops) {
  const Drive drive(Frames(12));
  RunOptions options = LidarOnly();
  options.deskew = Deskew::kNone;
  const RunResult whole = Play(drive, options);
  EXPECT_GT(whole.loops.second_look_ms, 0.0);
  const RunResult stopped =
      Play(drive, options, [](const FrameResult& frame) { return frame.id < 9; });
  EXPECT_EQ(stopped.loops.second_look_ms, 0.0);
  EXPECT_EQ(stopped.loops.graph.T_world.size(), stopped.map.keyframes.size()) << "polished";
}

TEST(RunSlam, TheSecondLookCanBeStopped) {
  const Drive drive(Frames(12));
  RunOptions options = LidarOnly();
  options.deskew = Deskew::kNone;
  for (const int threads : {1, 2}) {
    for (const int answers : {0, 4}) {  // yes so often, then no
      options.threads = threads;
      int asked = 0;
      DatasetSource source(drive);
      const RunResult result =
          RunSlam(source, options, SeeAll, [&asked, answers] { return ++asked <= answers; });
      EXPECT_EQ(asked, answers + 1) << "not asked again once stopped";
      EXPECT_TRUE(result.stopped);
      EXPECT_TRUE(result.loops.second_look_stopped);
      EXPECT_EQ(result.frames.size(), 12u);
      EXPECT_EQ(result.trajectory.size(), 12u);
      EXPECT_EQ(result.loops.graph.T_world.size(), result.map.keyframes.size()) << "polished";
    }
  }
}

// A drive with one frame's data exchanged.
class DriveWith : public Drive {
 public:
  DriveWith(const DriveOptions& options, std::set<size_t> frames, LidarScan scan)
      : Drive(options), frames_(std::move(frames)), scan_(std::move(scan)) {}
  SensorFrame Frame(size_t index) const override {
    SensorFrame frame = Drive::Frame(index);
    if (frames_.count(index) > 0) frame.scan = std::make_shared<LidarScan>(scan_);
    return frame;
  }

 private:
  std::set<size_t> frames_;
  LidarScan scan_;
};

// The frames before it are not lost: with and without the trial that decides the de-skewing.
TEST(RunSlam, WhatEndsARunLeavesItsResults) {
  class Torn : public Drive {
   public:
    explicit Torn(size_t first) : Drive(Frames(9)), first_(first) {}
    SensorFrame Frame(size_t index) const override {
      TVL_CHECK(index < first_) << "torn";
      return Drive::Frame(index);
    }

   private:
    size_t first_;
  };
  for (const int threads : {1, 2}) {
    for (const bool given : {true, false}) {
      RunOptions options = LidarOnly();
      options.threads = threads;
      if (given) options.deskew = Deskew::kNone;
      const RunResult result = Play(Torn(6), options);
      EXPECT_THROW(std::rethrow_exception(result.failure), Error);
      EXPECT_TRUE(result.stopped);
      EXPECT_EQ(result.frames.size(), 6u);
      EXPECT_EQ(result.trajectory.size(), 6u);
      EXPECT_EQ(result.loops.graph.T_world.size(), result.map.keyframes.size());
      EXPECT_THROW(Play(Torn(0), options), Error);
    }
  }
  EXPECT_EQ(Play(Drive(Frames(3)), LidarOnly()).failure, nullptr);
}

std::string ErrorOf(const Dataset& drive, const RunOptions& options, size_t* seen) {
  DatasetSource source(drive);
  try {
    RunSlam(source, options, [seen](const FrameResult&) { return ++*seen > 0; });
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(RunSlam, RefusesAnInputWithoutAnyScanAndSaysWhatIsWrongWithTheFirst) {
  LidarScan odd;
  odd.points.assign(100, Eigen::Vector3f(5.0f, 1.0f, 0.0f));
  odd.ring.assign(100, 77);
  RunOptions options = LidarOnly();
  size_t seen = 0;
  for (const bool given : {true, false}) {
    if (given) options.deskew = Deskew::kNone;
    if (!given) options.deskew.reset();
    const std::string error = ErrorOf(DriveWith(Frames(9), {0, 4}, odd), options, &seen);
    EXPECT_NE(error.find("frame 0: scan: ring 77"), std::string::npos) << error;
    EXPECT_NE(error.find("--frames 1:"), std::string::npos) << error;
    EXPECT_EQ(seen, 0u) << "refused at once";
  }
  const std::string empty = ErrorOf(DriveWith(Frames(3), {0, 1, 2}, LidarScan()), options, &seen);
  EXPECT_NE(empty.find("no frame of 3 has a usable scan: frame 0: its scan has no valid point"),
            std::string::npos)
      << empty;
  EXPECT_EQ(ErrorOf(DriveWith(Frames(9), {4}, odd), options, &seen), "");
}

TEST(RunSlam, TheUserThenTheInputSayHowToDeskew) {
  Drive drive(Frames(3));
  drive.setup().deskew = Deskew::kClockwise;
  RunOptions options = LidarOnly();
  EXPECT_EQ(Play(drive, options).deskew.deskew, Deskew::kClockwise);
  EXPECT_EQ(Play(drive, options).deskew.verdict, DeskewVerdict::kGiven);
  options.deskew = Deskew::kNone;
  EXPECT_EQ(Play(drive, options).deskew.deskew, Deskew::kNone);
  EXPECT_NE(Play(drive, options).deskew.reason, "");
}

class DeskewDecisionOn : public ::testing::TestWithParam<Deskew> {};

TEST_P(DeskewDecisionOn, TheDataDecide) {
  Drive drive(Frames(25, GetParam()));
  // A wrong default: it must not matter.
  drive.setup().default_deskew = GetParam() == Deskew::kNone ? Deskew::kClockwise : Deskew::kNone;
  RunOptions options = LidarOnly();
  options.decision.min_informative = 8;
  const RunResult result = Play(drive, options);
  EXPECT_EQ(result.deskew.verdict, DeskewVerdict::kDecided) << result.deskew.reason;
  EXPECT_EQ(result.deskew.deskew, GetParam()) << result.deskew.reason;
  EXPECT_GE(result.deskew.informative, options.decision.min_informative);
  EXPECT_EQ(result.frames.size(), 25u) << "frames looked at to decide are run as well";
  EXPECT_EQ(result.frames[0].id, 0);
  // From the first frame on as if the answer had been known.
  options.deskew = GetParam();
  const RunResult given = Play(drive, options);
  ASSERT_EQ(given.frames.size(), result.frames.size());
  for (size_t i = 0; i < given.frames.size(); ++i) {
    EXPECT_EQ(given.frames[i].T_world_lidar.Log(), result.frames[i].T_world_lidar.Log());
  }
}

TEST(DeskewDecision, TheObserverCanStopItAndResultsAreKept) {
  const Drive drive(Frames(10));
  const RunResult result =
      Play(drive, LidarOnly(), [](const FrameResult& frame) { return frame.id < 3; });
  EXPECT_TRUE(result.stopped);
  EXPECT_EQ(result.frames.size(), 4u);
  EXPECT_FALSE(result.map.keyframes.empty());
}

INSTANTIATE_TEST_SUITE_P(CompensatedAndRaw, DeskewDecisionOn,
                         ::testing::Values(Deskew::kNone, Deskew::kClockwise,
                                           Deskew::kCounterClockwise));

TEST(DeskewDecision, TimesOfThePointsTellTheSpin) {
  DriveOptions raw = Frames(25, Deskew::kCounterClockwise);
  raw.point_times = Deskew::kCounterClockwise;
  RunOptions options = LidarOnly();
  options.decision.min_informative = 8;
  const RunResult result = Play(Drive(raw), options);
  EXPECT_EQ(result.deskew.verdict, DeskewVerdict::kDecided) << result.deskew.reason;
  EXPECT_NE(result.deskew.reason.find("by the times of the points"), std::string::npos);
  raw.point_times = Deskew::kNone;
  options.deskew = Deskew::kCounterClockwise;
  const RunResult known = Play(Drive(raw), options);
  const Rigid3d apart =
      known.frames.back().T_world_lidar.Inverse() * result.frames.back().T_world_lidar;
  // Times to the microsecond instead of azimuths put some points into other voxels: as far apart as
  // two choices of points.
  EXPECT_LT(apart.t().norm(), 5e-3) << "as if the spin had been known";
}

TEST(DeskewDecision, TimesOfCompensatedPointsAreNotUsed) {
  DriveOptions compensated = Frames(25);
  compensated.point_times = Deskew::kClockwise;
  RunOptions options = LidarOnly();
  options.decision.min_informative = 8;
  const RunResult result = Play(Drive(compensated), options);
  EXPECT_EQ(result.deskew.verdict, DeskewVerdict::kDecided) << result.deskew.reason;
  EXPECT_EQ(result.deskew.deskew, Deskew::kNone) << result.deskew.reason;
}

TEST(DeskewDecision, AStandingSensorTellsNothing) {
  DriveOptions options = Frames(6);
  options.speed_m_s = 0.0;
  options.sway_m = 0.0;
  Drive drive(options);
  drive.setup().default_deskew = Deskew::kCounterClockwise;
  const RunResult result = Play(drive, LidarOnly());
  EXPECT_EQ(result.deskew.verdict, DeskewVerdict::kUndecided);
  EXPECT_EQ(result.deskew.deskew, Deskew::kCounterClockwise);
  EXPECT_NE(result.deskew.reason, "");
}

TEST(RunOptions, NameTheBadField) {
  RunOptions options;
  options.threads = 0;
  const Drive drive(Frames(1));
  EXPECT_THROW(Play(drive, options), InputError);
}

}  // namespace
}  // namespace tvl
