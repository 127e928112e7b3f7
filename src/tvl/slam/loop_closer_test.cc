#include "tvl/slam/loop_closer.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/loop/test_passes.h"

namespace tvl {
namespace {

using synthetic::OnStreet;
using synthetic::RandomHouses;

constexpr int kForth = 61, kBack = 56;

// Forth along a street and back on its other side, a keyframe a metre, half a second each, while
// the odometry turns and climbs. claimed_variance: factor on the covariances it states.
class ForthAndBack {
 public:
  ForthAndBack(const synthetic::World& first, const synthetic::World& second,
               const Rigid3d& drift_per_m, double claimed_variance = 1.0)
      : store_(std::make_shared<KeyframeStore>(KeyframeStoreOptions())),
        claimed_variance_(claimed_variance) {
    for (int k = 0; k < kForth; ++k) Add(first, OnStreet(k, 1.0, 0.0), drift_per_m);
    for (int k = 0; k < kBack; ++k) Add(second, OnStreet(60.0 - k, -1.0, kPi), drift_per_m);
  }

  LoopUpdate Run(LoopCloser* closer) const {
    for (const Keyframe& keyframe : keyframes_) {
      closer->Process(keyframe, *store_->Get(keyframe.id.index));
    }
    const LoopUpdate second_look = closer->LookAgain();
    const LoopUpdate polished = closer->Polish();
    return polished.T_world_lidar.empty() ? second_look : polished;
  }
  LoopCloser MakeCloser(const LoopOptions& options = {}) const {
    return {options, synthetic::CameraAndLidar(), store_};
  }
  Rigid3d Truth(int k) const { return truth_.front().Inverse() * truth_.at(size_t(k)); }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }

  // Error of the last pose relative to the first, m.
  double EndError_m(const Rigid3d& T_first, const Rigid3d& T_last) const {
    return (Truth(kForth + kBack - 1).t() - (T_first.Inverse() * T_last).t()).norm();
  }
  double LoopError_m(const LoopRecord& record) const {
    const Rigid3d T = Truth(record.proposal.history).Inverse() * Truth(record.proposal.current);
    return (T.Inverse() * record.verdict.T_history_current).t().norm();
  }

 private:
  void Add(const synthetic::World& world, const Rigid3d& T_world, const Rigid3d& drift) {
    auto payload = std::make_shared<KeyframePayload>();
    const synthetic::LaserNoise noise{0.02, truth_.size() + 1};
    const LaserFeatures features =
        synthetic::SampleFeatures(world, synthetic::Standing(T_world), Deskew::kNone, noise);
    payload->cloud.planes.points = synthetic::PointsOf(features.less_flat);
    payload->cloud.edges.points = synthetic::PointsOf(features.less_sharp);
    Keyframe keyframe;
    keyframe.id.index = static_cast<int>(truth_.size());
    keyframe.frame = 5 * keyframe.id.index;
    keyframe.stamp = Timestamp::FromSeconds(0.5 * keyframe.id.index);
    if (!truth_.empty()) {
      keyframe.T_prev_cur = truth_.back().Inverse() * T_world * drift;
      keyframe.path_m = keyframes_.back().path_m + keyframe.T_prev_cur.t().norm();
      keyframe.T_odom_lidar = keyframes_.back().T_odom_lidar * keyframe.T_prev_cur;
      keyframe.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4;
      keyframe.covariance *= claimed_variance_;
    }
    store_->Put(keyframe.id.index, payload);
    keyframes_.push_back(keyframe);
    truth_.push_back(T_world);
  }

  std::shared_ptr<KeyframeStore> store_;
  double claimed_variance_;
  std::vector<Keyframe> keyframes_;
  std::vector<Rigid3d> truth_;
};

Rigid3d Drift() { return Rigid3d::Exp(synthetic::Twist(0, 2e-4, 5e-4, 0, 0, 0.004)); }

int Accepted(const LoopReport& report) {
  int accepted = 0;
  for (const LoopRecord& record : report.records) {
    accepted += record.outcome == LoopOutcome::kAccepted;
  }
  return accepted;
}

TEST(LoopCloser, BringsADriftedReturnHome) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift());
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  const auto& keyframes = drive.keyframes();
  ASSERT_EQ(update.T_world_lidar.size(), keyframes.size());
  const double before_m =
      drive.EndError_m(keyframes.front().T_odom_lidar, keyframes.back().T_odom_lidar);
  EXPECT_GT(before_m, 0.5);
  EXPECT_LT(drive.EndError_m(update.T_world_lidar.front(), update.T_world_lidar.back()), 0.15);
  EXPECT_GE(Accepted(closer.report()), 10);
  for (const LoopRecord& record : closer.report().records) {
    if (record.outcome != LoopOutcome::kAccepted) continue;
    EXPECT_LT(drive.LoopError_m(record), 0.1);
  }
}

TEST(LoopCloser, KeepsTheFirstPoseAndReportsEveryKeyframe) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift());
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  EXPECT_LT((update.T_world_lidar.front().t() - drive.keyframes().front().T_odom_lidar.t()).norm(),
            1e-9);
  EXPECT_EQ(closer.report().times.size(), drive.keyframes().size());
  EXPECT_EQ(closer.report().graph.odometry.size() + 1, drive.keyframes().size());
  EXPECT_EQ(static_cast<int>(closer.report().graph.loops.size()), Accepted(closer.report()));
}

TEST(LoopCloser, RefusesAStreetThatOnlyLiesThere) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(2), Drift());
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  EXPECT_GT(closer.report().records.size(), 10U);
  EXPECT_EQ(Accepted(closer.report()), 0);
  EXPECT_TRUE(update.T_world_lidar.empty());  // the odometry stands
}

TEST(LoopCloser, ProposersCanBeLeftOut) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Rigid3d());
  LoopOptions options;
  options.use_vicinity = false;
  LoopCloser lidar_only = drive.MakeCloser(options);
  drive.Run(&lidar_only);
  EXPECT_GT(Accepted(lidar_only.report()), 0);
  for (const LoopRecord& record : lidar_only.report().records) {
    EXPECT_EQ(record.proposal.proposer, LoopProposer::kLidar);
  }
  options.use_lidar = false;
  LoopCloser none = drive.MakeCloser(options);
  drive.Run(&none);
  EXPECT_TRUE(none.report().records.empty());
}

TEST(LoopCloser, ALoopTheGraphContradictsStaysOut) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift());
  LoopOptions options;
  options.consistency.max_chi2 = options.consistency.max_chi2_of_rows = 1e-6;
  LoopCloser closer = drive.MakeCloser(options);
  drive.Run(&closer);
  EXPECT_EQ(Accepted(closer.report()), 0);
  EXPECT_EQ(closer.report().records.back().outcome, LoopOutcome::kInconsistent);
}

TEST(LoopCloser, ARowThatAgreesIsBelievedAgainstTheGraph) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift(), 0.4);
  LoopOptions options;
  options.consistency.drift_floor_m = options.consistency.drift_share = 0.0;
  options.consistency.drift_rad_per_m = 0.0;
  options.consistency.graph_inflation = 1.0;  // and so the graph contradicts all of them
  LoopCloser closer = drive.MakeCloser(options);
  drive.Run(&closer);
  EXPECT_GE(Accepted(closer.report()), 10);
  options.consistency.min_row_m = 100.0;  // longer than the street
  LoopCloser strict = drive.MakeCloser(options);
  drive.Run(&strict);
  EXPECT_EQ(Accepted(strict.report()), 0);
}

TEST(LoopCloser, OdometryMuchWorseThanItThinksLosesNoTrueLoop) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift(), 0.01);
  LoopCloser closer = drive.MakeCloser();
  const LoopUpdate update = drive.Run(&closer);
  EXPECT_GT(closer.report().odometry_variance_factor, 10.0);
  for (const LoopRecord& record : closer.report().records) {
    EXPECT_NE(record.outcome, LoopOutcome::kDropped) << record.proposal.current;
  }
  EXPECT_LT(drive.EndError_m(update.T_world_lidar.front(), update.T_world_lidar.back()), 0.15);
}

TEST(LoopCloser, OneLoopAloneIsNotBelieved) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift());
  LoopOptions options;
  options.consistency.min_support = 1000;
  LoopCloser closer = drive.MakeCloser(options);
  drive.Run(&closer);
  EXPECT_EQ(Accepted(closer.report()), 0);
}

TEST(LoopCloser, IsTheSameToTheBit) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift());
  LoopCloser a = drive.MakeCloser(), b = drive.MakeCloser();
  const LoopUpdate first = drive.Run(&a), second = drive.Run(&b);
  for (size_t k = 0; k < first.T_world_lidar.size(); ++k) {
    EXPECT_EQ(first.T_world_lidar[k].t(), second.T_world_lidar[k].t());
  }
}

TEST(LoopCloser, RefusesKeyframesOutOfTurn) {
  const ForthAndBack drive(RandomHouses(1), RandomHouses(1), Drift());
  LoopCloser closer = drive.MakeCloser();
  EXPECT_THROW(closer.Process(drive.keyframes()[1], KeyframePayload()), Error);
}

TEST(LoopOptions, NameTheBadField) {
  LoopOptions options;
  options.consistency.graph_inflation = 0.5;
  try {
    options.Check();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("loops.consistency.graph_inflation"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace tvl
