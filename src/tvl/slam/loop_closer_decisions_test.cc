// What the loop closer does beside accepting what lies at hand: doubts, drops, looks again.
#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/loop/test_places.h"
#include "tvl/slam/test_forth_and_back.h"

namespace tvl {
namespace {

using synthetic::Box;
using synthetic::CameraAndLidar;
using synthetic::CountOf;
using synthetic::ForthAndBack;
using synthetic::KeyframeDrive;
using synthetic::OnStreet;
using synthetic::Plane;
using synthetic::RandomHouses;
using synthetic::SlowDrift;
using synthetic::World;

TEST(LoopCloser, APlaceThatIsClosedIsNotVerifiedTwice) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), SlowDrift());
  LoopCloser closer = drive.MakeCloser();
  drive.Run(&closer);
  EXPECT_GT(CountOf(LoopOutcome::kCovered, closer.report()), 5);
  std::vector<int> accepted;  // of current keyframes; there is one pass to close with
  for (const LoopRecord& record : closer.report().records) {
    if (record.outcome == LoopOutcome::kCovered) {
      EXPECT_EQ(record.verdict.points, 0) << "looked at";
      EXPECT_EQ(accepted.empty() ? -1 : accepted.back(), record.proposal.current);
    }
    if (record.verdict.accepted()) accepted.push_back(record.proposal.current);
  }
  EXPECT_EQ(std::adjacent_find(accepted.begin(), accepted.end()), accepted.end());
}

// The odometry slips sideways where it turns round, and knows. Only near the start is its estimate
// believed to be that uncertain, and what is found there puts all the rest within reach.
class SlipAtTheTurn : public KeyframeDrive {
 public:
  static constexpr int kForth = 61;
  SlipAtTheTurn() {
    const World world = RandomHouses(1);
    for (int k = 0; k < kForth; ++k) Put(world, OnStreet(k, 1.0, 0.0), {});
    const Step slip{Rigid3d::Translation(0, 4.0, 0), 1.0, 16.0};
    for (int k = 0; k < 56; ++k) Put(world, OnStreet(60.0 - k, -1.0, kPi), k == 0 ? slip : Step());
  }
  static LoopOptions Options() {
    LoopOptions options;
    options.use_visual = options.use_lidar = false;
    options.drift.vicinity_floor_m = 3.0;
    options.drift.vicinity_share = 0.065;  // 6 m of 92 m
    return options;
  }

 private:
  void Put(const World& world, const Rigid3d& T, const Step& step) { Add(world, T, step, T); }
};

TEST(LoopCloser, ALaterLoopBringsEarlierKeyframesWithinReach) {
  const SlipAtTheTurn drive;
  LoopCloser closer = drive.MakeCloser(SlipAtTheTurn::Options());
  const LoopUpdate update = drive.Run(&closer);
  int late = 0;
  for (const LoopRecord& record : closer.report().records) {
    late += record.is_second_look && record.outcome == LoopOutcome::kAccepted;
    EXPECT_TRUE(record.is_second_look || record.proposal.current > 100);
  }
  EXPECT_GE(late, 10);
  for (int k = 90; k < 117; ++k) {
    const auto& T = update.T_world_lidar;
    EXPECT_LT(drive.Error_m(T.front(), T.at(static_cast<size_t>(k)), k), 0.05) << k;
  }
}

// On the way back part of the street looks as if it had slid along by metres.
class SlidStretch : public KeyframeDrive {
 public:
  SlidStretch() {
    const World world = RandomHouses(1);
    for (int k = 0; k < 61; ++k) Put(world, OnStreet(k, 1.0, 0.0), 0.0);
    for (int k = 0; k < 56; ++k) {
      const double slid_m = k >= 28 && k < 42 ? 4.0 : 0.0;
      Put(world, OnStreet(60.0 - k, -1.0, kPi), slid_m);
    }
  }

 private:
  void Put(const World& world, const Rigid3d& T, double slid_m) {
    Add(world, T, {}, Rigid3d::Translation(slid_m, 0, 0) * T);
  }
};

TEST(LoopCloser, ALoopThatAllOthersContradictIsDroppedInTheEnd) {
  const SlidStretch drive;
  LoopOptions options;
  options.consistency.linked_path_m = 1e6;  // believes everything
  options.consistency.max_chi2 = options.consistency.max_chi2_of_rows = 1e9;
  LoopCloser closer = drive.MakeCloser(options);
  drive.Run(&closer);
  const LoopReport& report = closer.report();
  for (const LoopRecord& record : report.records) {
    const bool is_out = record.outcome == LoopOutcome::kDropped;
    if (!is_out && record.outcome != LoopOutcome::kAccepted) continue;
    EXPECT_EQ(is_out, drive.LoopError_m(record) > 1.0) << record.proposal.current;
    EXPECT_EQ(is_out, record.weight < 0.5);
    EXPECT_EQ(is_out, !record.reason.empty());
  }
  EXPECT_GE(CountOf(LoopOutcome::kDropped, report), 3);
  EXPECT_GE(CountOf(LoopOutcome::kAccepted, report), 10);
}

// Up to 25 m as RandomHouses, then houses every 12 m, all alike.
World HalfIdentical() {
  World world;
  world.surfaces = {Plane({0, 0, 1}, -1.7)};
  Rng rng(1);
  for (const double side : {-1.0, 1.0}) {
    for (double x = -60.0; x < 130.0; x += x < 25.0 ? rng.Uniform(8.0, 16.0) : 12.0) {
      const bool is_alike = x > 25.0;
      const double width = is_alike ? 6.0 : rng.Uniform(4.0, 7.0);
      const double front = side * (is_alike ? 6.0 : rng.Uniform(4.5, 10.0));
      const double back = front + side * 4.0, top = is_alike ? 5.0 : rng.Uniform(2.0, 6.0);
      world.surfaces.push_back(
          Box({x, std::min(front, back), -1.7}, {x + width, std::max(front, back), top}));
      world.edges.emplace_back(x, front);
      world.edges.emplace_back(x + width, front);
    }
  }
  return world;
}

TEST(LoopCloser, AmongAmbiguousComparisonsSupportIsNotEnough) {
  const ForthAndBack drive(HalfIdentical(), HalfIdentical(), Rigid3d());
  LoopOptions options;
  options.use_lidar = false;
  options.separation.min_path_m = 20.0;
  options.separation.min_time_s = 5.0;
  options.consistency.linked_path_m = 5.0;
  options.consistency.min_support_share = 0.5;
  LoopCloser content = drive.MakeCloser(options);
  drive.Run(&content);
  EXPECT_GE(CountOf(LoopOutcome::kAccepted, content.report()), 10);
  options.consistency.min_support_share = 0.95;  // one comparison in ten is ambiguous at best
  LoopCloser strict = drive.MakeCloser(options);
  drive.Run(&strict);
  EXPECT_EQ(CountOf(LoopOutcome::kAccepted, strict.report()), 0);
  EXPECT_GE(CountOf(LoopOutcome::kUnsupported, strict.report()), 10);
}

// Forth and back in reverse, with a camera that sees points beside the street.
class ReverseWithCamera : public KeyframeDrive {
 public:
  ReverseWithCamera() {
    const World world = RandomHouses(1);
    Rng rng(5);
    for (int x = 0; x < 90; ++x) {  // 12 a metre of street, cameras' axes
      for (PlacePoint point : MakePlace(12, 100 + static_cast<uint64_t>(x))) {
        point.p_world = {x + rng.Uniform(), -point.p_world.x(), -point.p_world.y()};
        points_.push_back(point);
      }
    }
    for (int k = 0; k < 61; ++k) Put(world, OnStreet(k, 0.5, 0.0));
    for (int k = 0; k < 40; ++k) Put(world, OnStreet(60.3 - k, -0.5, 0.0));
  }

 private:
  void Put(const World& world, const Rigid3d& T) {
    const Rigid3d T_world_cam = T * CameraAndLidar().T_cam_lidar.Inverse();
    Place ahead;
    for (const PlacePoint& point : points_) {
      const double ahead_m = point.p_world.x() - T.t().x();
      if (ahead_m > 5.0 && ahead_m < 20.0) ahead.push_back(point);
    }
    const uint64_t seed = keyframes().size();
    Add(world, T, {SlowDrift()}, T, See(ahead, T_world_cam, 0.5, seed));
  }
  Place points_;
};

TEST(LoopCloser, TheCameraAloneFindsTheWayBack) {
  const ReverseWithCamera drive;
  LoopOptions options;
  options.use_vicinity = options.use_lidar = false;
  options.separation.min_time_s = 10.0;
  LoopCloser closer = drive.MakeCloser(options);
  const LoopUpdate update = drive.Run(&closer);
  EXPECT_GE(CountOf(LoopOutcome::kAccepted, closer.report()), 10);
  for (const LoopRecord& record : closer.report().records) {
    EXPECT_EQ(record.proposal.proposer, LoopProposer::kVisual);
    if (record.outcome != LoopOutcome::kAccepted) continue;
    EXPECT_LT(drive.LoopError_m(record), 0.15);
  }
  ASSERT_FALSE(update.T_world_lidar.empty());
  // The error of a loop and what the steps since the last loop add.
  EXPECT_LT(drive.EndError_m(update.T_world_lidar.front(), update.T_world_lidar.back()), 0.2);
  options.use_visual = false;
  LoopCloser blind = drive.MakeCloser(options);
  drive.Run(&blind);
  EXPECT_TRUE(blind.report().records.empty());
}

}  // namespace
}  // namespace tvl
