// Drives there and back through synthetic worlds, as keyframes with an odometry that drifts. For
// tests only.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "tvl/loop/test_passes.h"
#include "tvl/map/keyframe_store.h"
#include "tvl/slam/loop_closer.h"

namespace tvl::synthetic {

// Keyframes half a second apart.
class KeyframeDrive {
 public:
  LoopUpdate Run(LoopCloser* closer) const {
    for (const Keyframe& keyframe : keyframes_) {
      closer->Process(keyframe, *store_->Get(keyframe.id.index));
    }
    const LoopUpdate second_look = closer->LookAgain();
    const LoopUpdate polished = closer->Polish();
    return polished.T_world_lidar.empty() ? second_look : polished;
  }
  LoopCloser MakeCloser(const LoopOptions& options = {}) const {
    return {options, CameraAndLidar(), store_};
  }
  Rigid3d Truth(int k) const { return truth_.front().Inverse() * truth_.at(size_t(k)); }
  const std::vector<Keyframe>& keyframes() const { return keyframes_; }

  // Error of a pose relative to the first, m.
  double Error_m(const Rigid3d& T_first, const Rigid3d& T_k, int k) const {
    return (Truth(k).t() - (T_first.Inverse() * T_k).t()).norm();
  }
  double EndError_m(const Rigid3d& T_first, const Rigid3d& T_last) const {
    return Error_m(T_first, T_last, static_cast<int>(truth_.size()) - 1);
  }
  double LoopError_m(const LoopRecord& record) const {
    const Rigid3d T = Truth(record.proposal.history).Inverse() * Truth(record.proposal.current);
    return (T.Inverse() * record.verdict.T_history_current).t().norm();
  }

 protected:
  // A step of the odometry: its error and what it says of it (diagonal, [rotation, translation]).
  struct Step {
    Rigid3d drift;
    double variance_factor = 1.0;
    double side_variance_m2 = 0.0;  // in addition
  };
  // The lidar stands at T_world, what it sees is seen from T_seen.
  void Add(const World& world, const Rigid3d& T_world, const Step& step, const Rigid3d& T_seen,
           ImageFeatures image = {}) {
    auto payload = std::make_shared<KeyframePayload>();
    const LaserNoise noise{0.02, truth_.size() + 1};
    const LaserFeatures features = SampleFeatures(world, Standing(T_seen), Deskew::kNone, noise);
    payload->cloud.planes.points = PointsOf(features.less_flat);
    payload->cloud.edges.points = PointsOf(features.less_sharp);
    payload->image = std::move(image);
    Keyframe keyframe;
    keyframe.id.index = static_cast<int>(truth_.size());
    keyframe.frame = 5 * keyframe.id.index;
    keyframe.stamp = Timestamp::FromSeconds(0.5 * keyframe.id.index);
    if (!truth_.empty()) {
      keyframe.T_prev_cur = truth_.back().Inverse() * T_world * step.drift;
      keyframe.path_m = keyframes_.back().path_m + keyframe.T_prev_cur.t().norm();
      keyframe.T_odom_lidar = keyframes_.back().T_odom_lidar * keyframe.T_prev_cur;
      keyframe.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4;
      keyframe.covariance *= step.variance_factor;
      keyframe.covariance(4, 4) += step.side_variance_m2;
    }
    store_->Put(keyframe.id.index, payload);
    keyframes_.push_back(keyframe);
    truth_.push_back(T_world);
  }

 private:
  std::shared_ptr<KeyframeStore> store_ = std::make_shared<KeyframeStore>(KeyframeStoreOptions());
  std::vector<Keyframe> keyframes_;
  std::vector<Rigid3d> truth_;
};

// Forth along a street and back on its other side, a keyframe a metre, while the odometry turns and
// climbs. claimed_variance: factor on the covariances it states.
class ForthAndBack : public KeyframeDrive {
 public:
  static constexpr int kForth = 61, kBack = 56;

  ForthAndBack(const World& first, const World& second, const Rigid3d& drift_per_m,
               double claimed_variance = 1.0) {
    const Step step{drift_per_m, claimed_variance};
    for (int k = 0; k < kForth; ++k) Put(first, OnStreet(k, 1.0, 0.0), step);
    for (int k = 0; k < kBack; ++k) Put(second, OnStreet(60.0 - k, -1.0, kPi), step);
  }

 private:
  void Put(const World& world, const Rigid3d& T, const Step& step) { Add(world, T, step, T); }
};

inline Rigid3d SlowDrift() { return Rigid3d::Exp(Twist(0, 2e-4, 5e-4, 0, 0, 0.004)); }

inline int CountOf(LoopOutcome outcome, const LoopReport& report) {
  int count = 0;
  for (const LoopRecord& record : report.records) count += record.outcome == outcome;
  return count;
}

}  // namespace tvl::synthetic
