#include "tvl/slam/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tvl/base/check.h"
#include "tvl/base/index.h"
#include "tvl/base/stopwatch.h"
#include "tvl/loop/vocabulary_file.h"
#include "tvl/slam/loop_support.h"

namespace tvl {
namespace {

// Of the keyframes a loop makes neighbours: a scan every two metres fills a surfel map.
constexpr int kEveryConnected = 2;

std::shared_ptr<const Vocabulary> LoadVocabulary(const std::string& path) {
  return std::make_shared<const Vocabulary>(path.empty() ? DefaultVocabulary()
                                                         : ReadVocabulary(path));
}

Matrix6d InformationOf(const Matrix6d& covariance) {
  return covariance.ldlt().solve(Matrix6d::Identity());
}

PoseConstraint ConstraintOf(const LoopRecord& record) {
  return {record.proposal.history, record.proposal.current, record.verdict.T_history_current,
          InformationOf(record.verdict.covariance)};
}

}  // namespace

const char* ToString(LoopOutcome outcome) {
  switch (outcome) {
    case LoopOutcome::kAccepted:
      return "accepted";
    case LoopOutcome::kRefused:
      return "refused";
    case LoopOutcome::kInconsistent:
      return "inconsistent";
    case LoopOutcome::kUnsupported:
      return "unsupported";
    case LoopOutcome::kCovered:
      return "covered";
    case LoopOutcome::kNotVerified:
      return "not_verified";
    case LoopOutcome::kDropped:
      return "dropped";
  }
  return "unknown";
}

class LoopCloser::Impl {
 public:
  Impl(const LoopOptions& options, const Calibration& calibration,
       std::shared_ptr<const KeyframeStore> store)
      : options_(options),
        store_(std::move(store)),
        visual_(LoadVocabulary(options.vocabulary), calibration, options.visual),
        lidar_(options.lidar_descriptor, options.lidar),
        verifier_(options.verification),
        graph_(options.graph) {}

  void Add(const Keyframe& keyframe, const KeyframePayload& payload, LoopTimes* times);
  std::vector<LoopProposal> Propose(int current, const std::vector<double>& linked_path_m,
                                    LoopTimes* times);
  // Verifies and weighs the proposals of one keyframe. linked_path_m: LinkedPath of it.
  void Judge(const std::vector<LoopProposal>& proposals, const std::vector<double>& linked_path_m,
             LoopTimes* times);
  // Puts the loops accepted since the last call into the graph; false if there are none.
  bool Close(LoopTimes* times);
  // True if poses changed.
  bool LookAgain(const std::function<bool()>& go_on);
  bool Polish();
  std::vector<int> ConnectedTo(int keyframe) const;

  std::vector<double> LinkedPathOf(int keyframe) const {
    return LinkedPath(track_.path_m, links_, keyframe);
  }
  int last() const { return track_.size() - 1; }
  const std::vector<Rigid3d>& poses() const { return track_.T_world_lidar; }
  LoopReport report;

 private:
  struct Pending {
    PoseConstraint loop;
    size_t record = 0;
  };
  double DistanceBetween(int a, int b) const {
    return (poses()[Index(a)].t() - poses()[Index(b)].t()).norm();
  }
  LoopRecord Verify(const LoopProposal& proposal, double linked_path_m);
  void Weigh(size_t record);
  // Those waiting that support the loop.
  std::vector<Pending> SupportOf(const PoseConstraint& loop) const;
  // Of the keyframes round the loop's current one that were compared with old ones: the share that
  // could tell one place from another.
  double ShareThatTold(const LoopRecord& loop) const;
  void Accept(const Pending& pending);
  LoopRecord Unjudged(const LoopProposal& proposal, double linked_path_m) const;
  // One of the records from `first` on leads to the same place.
  bool IsCovered(const LoopProposal& proposal, size_t first) const;
  // The same two stretches were compared before, and the estimate has hardly moved since.
  bool IsOldNews(const LoopProposal& proposal) const;

  LoopOptions options_;
  std::shared_ptr<const KeyframeStore> store_;
  VisualProposer visual_;
  LidarProposer lidar_;
  LoopVerifier verifier_;
  IncrementalPoseGraph graph_;
  OdometryChain odometry_;
  KeyframeTrack track_;
  std::vector<Rigid3d> T_odom_lidar_;
  std::vector<FrameId> frames_;
  std::vector<LoopLink> links_;       // accepted
  std::vector<char> has_loop_;        // by keyframe: the current one of an accepted loop
  std::vector<Pending> pending_;      // verified, waiting for support
  std::vector<PoseConstraint> new_;   // accepted, not yet in the graph
  std::vector<size_t> loop_records_;  // of each loop in the graph
  Executor executor_{1};
};

void LoopCloser::Impl::Add(const Keyframe& keyframe, const KeyframePayload& payload,
                           LoopTimes* times) {
  const Stopwatch watch;
  const int index = keyframe.id.index;
  TVL_CHECK(index == track_.size()) << "loop closer: keyframe " << index << " out of turn";
  T_odom_lidar_.push_back(keyframe.T_odom_lidar);
  frames_.push_back(keyframe.frame);
  has_loop_.push_back(0);
  if (index == 0) {
    graph_.AddFirst(keyframe.T_odom_lidar);
  } else {
    const PoseConstraint odometry{index - 1, index, keyframe.T_prev_cur,
                                  InformationOf(keyframe.covariance)};
    graph_.AddKeyframe(odometry);
    odometry_.Add(odometry);
  }
  track_.stamp.push_back(keyframe.stamp);
  track_.path_m.push_back(keyframe.path_m);
  track_.T_world_lidar = graph_.estimates();
  times->graph_ms = watch.ElapsedMs();
  const Stopwatch describe;
  if (options_.use_visual) visual_.Add(payload.image);
  if (options_.use_lidar) lidar_.Add(DescribePlace(payload.cloud, options_.lidar_descriptor));
  times->describe_ms = describe.ElapsedMs();
}

std::vector<LoopProposal> LoopCloser::Impl::Propose(int current,
                                                    const std::vector<double>& linked_m,
                                                    LoopTimes* times) {
  const int eligible = EligibleHistory(track_, current, options_.separation);
  if (eligible == 0) return {};
  std::vector<LoopProposal> all;
  const auto add = [&](const std::vector<LoopProposal>& some) {
    all.insert(all.end(), some.begin(), some.end());
  };
  Stopwatch watch;
  if (options_.use_visual) {
    const DriftRadius radius = options_.drift.visual();
    const auto may_match = [&](int history) {
      return history < eligible &&
             DistanceBetween(history, current) <= radius.Of(linked_m[Index(history)]);
    };
    add(visual_
            .Propose(
                current, [this](int k) { return store_->Image(k); }, may_match)
            .proposals);
  }
  times->propose_visual_ms = watch.LapMs();
  if (options_.use_vicinity) {
    add(ProposeVicinity(track_, current, linked_m, options_.drift.vicinity(), options_.separation,
                        options_.vicinity));
  }
  times->propose_vicinity_ms = watch.LapMs();
  if (options_.use_lidar) {
    add(lidar_.Propose(track_, current, linked_m, options_.drift.lidar(), options_.separation));
  }
  times->propose_lidar_ms = watch.LapMs();
  // Where the graph is tight its own guess is the best there is.
  const auto rank = [&](const LoopProposal& p) {
    if (p.guess != LoopGuess::kNone) return p.proposer == LoopProposer::kVisual ? 1 : 2;
    return linked_m[Index(p.history)] <= options_.consistency.linked_path_m ? 0 : 3;
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const LoopProposal& a, const LoopProposal& b) { return rank(a) < rank(b); });
  return all;
}

bool LoopCloser::Impl::IsCovered(const LoopProposal& proposal, size_t first) const {
  const auto begin = report.records.begin() + static_cast<std::ptrdiff_t>(first);
  return std::any_of(begin, report.records.end(), [&](const LoopRecord& record) {
    const double apart_m = std::abs(track_.path_m[Index(proposal.history)] -
                                    track_.path_m[Index(record.proposal.history)]);
    return record.verdict.accepted() && record.outcome != LoopOutcome::kInconsistent &&
           apart_m < options_.separation.pass_gap_m;
  });
}

LoopRecord LoopCloser::Impl::Verify(const LoopProposal& proposal, double linked_path_m) {
  LoopRecord record = Unjudged(proposal, linked_path_m);
  // Where the graph is tight a narrow search is enough: two metres, and four standard deviations.
  const double drift_m = options_.consistency.drift_share * linked_path_m;
  const double radius_m = linked_path_m <= options_.consistency.linked_path_m
                              ? 2.0 + 4.0 * drift_m
                              : options_.drift.vicinity().Of(linked_path_m);
  const VerificationInput input{T_odom_lidar_, [this](int k) { return store_->Cloud(k); },
                                record.T_history_current_graph, radius_m};
  record.verdict = verifier_.Verify(proposal, input, executor_);
  record.outcome = record.verdict.accepted() ? LoopOutcome::kUnsupported : LoopOutcome::kRefused;
  record.reason = record.verdict.reason;
  return record;
}

LoopRecord LoopCloser::Impl::Unjudged(const LoopProposal& proposal, double linked_path_m) const {
  LoopRecord record;
  record.proposal = proposal;
  record.history_frame = frames_[Index(proposal.history)];
  record.current_frame = frames_[Index(proposal.current)];
  record.linked_path_m = linked_path_m;
  record.T_history_current_graph =
      poses()[Index(proposal.history)].Inverse() * poses()[Index(proposal.current)];
  return record;
}

void LoopCloser::Impl::Judge(const std::vector<LoopProposal>& proposals,
                             const std::vector<double>& linked_path_m, LoopTimes* times) {
  const size_t first = report.records.size();
  int verified = 0;
  for (const LoopProposal& proposal : proposals) {
    const Stopwatch watch;
    const double linked_m = linked_path_m[Index(proposal.history)];
    if (IsCovered(proposal, first)) {
      report.records.push_back(Unjudged(proposal, linked_m));
      report.records.back().outcome = LoopOutcome::kCovered;
    } else if (verified >= options_.max_verifications) {
      report.records.push_back(Unjudged(proposal, linked_m));
    } else {
      ++verified;
      report.records.push_back(Verify(proposal, linked_m));
      if (report.records.back().verdict.accepted()) Weigh(report.records.size() - 1);
    }
    times->verify_ms += watch.ElapsedMs();
  }
}

void LoopCloser::Impl::Weigh(size_t index) {
  LoopRecord& record = report.records[index];
  const LoopConsistencyOptions& options = options_.consistency;
  const PoseConstraint loop = ConstraintOf(record);
  record.chi2 =
      GraphChi2(loop, record.T_history_current_graph, graph_.RelativeCovariance(loop.from, loop.to),
                record.linked_path_m, options);
  if (record.linked_path_m > options.linked_path_m) {
    record.innovation_sq = graph_.InnovationSq(loop);
  }
  const bool is_contradicted = !(record.chi2 <= options.max_chi2);
  const Pending pending{loop, index};
  if (!is_contradicted && record.linked_path_m <= options.linked_path_m) {
    Accept(pending);
    return;
  }
  const std::vector<Pending> support = SupportOf(loop);
  record.row_start_m = track_.path_m[Index(loop.to)];
  for (const Pending& other : support) {
    record.row_start_m = std::min(record.row_start_m, report.records[other.record].row_start_m);
  }
  pending_.push_back(pending);
  const double row_m = track_.path_m[Index(loop.to)] - record.row_start_m;
  record.reason = std::to_string(support.size()) + " other loops agree with it";
  if (is_contradicted) {
    record.outcome = LoopOutcome::kInconsistent;
    record.reason = "the graph contradicts it";
    if (row_m < options.min_row_m || !(record.chi2 <= options.max_chi2_of_rows)) return;
  }
  if (static_cast<int>(support.size()) < options.min_support) return;
  if (ShareThatTold(record) < options.min_support_share) {
    record.reason = "most comparisons hereabouts were ambiguous";
    return;
  }
  Accept(pending);
  for (const Pending& other : support) Accept(other);
}

std::vector<LoopCloser::Impl::Pending> LoopCloser::Impl::SupportOf(
    const PoseConstraint& loop) const {
  std::vector<Pending> near;
  std::vector<PoseConstraint> others;
  for (const Pending& pending : pending_) {
    const double apart_m =
        std::abs(track_.path_m[Index(pending.loop.to)] - track_.path_m[Index(loop.to)]);
    if (apart_m > options_.consistency.max_support_path_m) continue;
    near.push_back(pending);
    others.push_back(pending.loop);
  }
  std::vector<Pending> support;
  for (const size_t i : FindSupport(loop, others, odometry_, track_.path_m, options_.consistency)) {
    support.push_back(near[i]);
  }
  return support;
}

double LoopCloser::Impl::ShareThatTold(const LoopRecord& loop) const {
  const double path_m = track_.path_m[Index(loop.proposal.current)];
  std::map<int, bool> told;  // by current keyframe
  for (const LoopRecord& record : report.records) {
    const int keyframe = record.proposal.current;
    const double apart_m = std::abs(track_.path_m[Index(keyframe)] - path_m);
    if (apart_m > options_.consistency.max_doubt_path_m) continue;
    const LoopStatus status = record.verdict.status;
    // What the graph contradicts told of the place only if the loop continues its row.
    const bool agrees =
        record.outcome != LoopOutcome::kInconsistent || record.row_start_m == loop.row_start_m;
    if (record.verdict.accepted() && agrees) told[keyframe] = true;
    if (!agrees || status == LoopStatus::kAmbiguous || status == LoopStatus::kContradicted) {
      told.emplace(keyframe, false);
    }
  }
  const auto count =
      std::count_if(told.begin(), told.end(), [](const auto& t) { return t.second; });
  return told.empty() ? 1.0 : static_cast<double>(count) / static_cast<double>(told.size());
}

void LoopCloser::Impl::Accept(const Pending& pending) {
  LoopRecord& record = report.records[pending.record];
  if (record.outcome == LoopOutcome::kAccepted) return;
  record.outcome = LoopOutcome::kAccepted;
  record.reason.clear();
  links_.push_back({pending.loop.from, pending.loop.to});
  has_loop_[Index(pending.loop.to)] = 1;
  new_.push_back(pending.loop);
  loop_records_.push_back(pending.record);
}

bool LoopCloser::Impl::Close(LoopTimes* times) {
  if (new_.empty()) return false;
  const Stopwatch watch;
  graph_.AddLoops(new_);
  new_.clear();
  track_.T_world_lidar = graph_.estimates();
  times->graph_ms += watch.ElapsedMs();
  return true;
}

std::vector<int> LoopCloser::Impl::ConnectedTo(int keyframe) const {
  std::vector<std::pair<double, int>> near;
  std::vector<char> seen(Index(keyframe) + 1, 0);
  for (const LoopLink& link : links_) {
    if (track_.path_m[Index(keyframe)] - track_.path_m[Index(link.to)] >
        options_.connected_path_m) {
      continue;
    }
    const int each_way = options_.verification.submap.keyframes_each_way;
    const int begin = std::max(0, link.from - each_way);
    const int end = std::min(keyframe, link.from + each_way + 1);
    for (int k = begin + begin % kEveryConnected; k < end; k += kEveryConnected) {
      if (seen[Index(k)] != 0) continue;
      seen[Index(k)] = 1;
      near.emplace_back(DistanceBetween(k, keyframe), k);
    }
  }
  std::sort(near.begin(), near.end());
  std::vector<int> connected;
  for (const auto& [distance_m, k] : near) connected.push_back(k);
  return connected;
}

bool LoopCloser::Impl::IsOldNews(const LoopProposal& proposal) const {
  constexpr double kMoved_m = 1.0, kMoved_rad = 0.035;  // what a search starts anew for
  const Rigid3d T_now =
      poses()[Index(proposal.history)].Inverse() * poses()[Index(proposal.current)];
  return std::any_of(report.records.begin(), report.records.end(), [&](const LoopRecord& record) {
    if (record.proposal.current != proposal.current) return false;
    if (std::abs(record.proposal.history - proposal.history) > 3) return false;
    const Rigid3d T_then = T_odom_lidar_[Index(proposal.history)].Inverse() *
                           T_odom_lidar_[Index(record.proposal.history)] *
                           record.T_history_current_graph;
    const Rigid3d moved = T_then.Inverse() * T_now;
    return moved.t().norm() < kMoved_m && moved.RotationAngle() < kMoved_rad;
  });
}

bool LoopCloser::Impl::LookAgain(const std::function<bool()>& go_on) {
  report.second_look_stopped = !go_on();
  if (report.second_look_stopped) return false;
  const Stopwatch watch;
  LoopTimes times;
  const size_t before = report.records.size();
  bool has_closed = false;
  for (int k = 0; k <= last() && options_.use_vicinity; ++k) {
    if (has_loop_[Index(k)] != 0) continue;
    report.second_look_stopped = !go_on();
    if (report.second_look_stopped) break;
    const std::vector<double> linked_m = LinkedPathOf(k);
    std::vector<LoopProposal> proposals = ProposeVicinity(
        track_, k, linked_m, options_.drift.vicinity(), options_.separation, options_.vicinity);
    proposals.erase(std::remove_if(proposals.begin(), proposals.end(),
                                   [this](const LoopProposal& p) { return IsOldNews(p); }),
                    proposals.end());
    Judge(proposals, linked_m, &times);
    has_closed = Close(&times) || has_closed;
  }
  for (size_t i = before; i < report.records.size(); ++i) report.records[i].is_second_look = true;
  report.second_look_ms = watch.ElapsedMs();
  return has_closed;
}

bool LoopCloser::Impl::Polish() {
  const Stopwatch watch;
  report.graph = graph_.Graph();
  if (report.graph.loops.empty()) return false;  // the odometry contradicts nothing
  std::vector<double> innovations_sq;
  for (const size_t i : loop_records_) {
    const LoopRecord& record = report.records[i];
    if (record.linked_path_m > options_.consistency.linked_path_m) {
      innovations_sq.push_back(record.innovation_sq);
    }
  }
  report.odometry_variance_factor = OdometryVarianceFactor(std::move(innovations_sq));
  const BatchPoseGraphResult result = OptimizeBatch(
      WithOdometryVariance(report.graph, report.odometry_variance_factor), options_.polish);
  report.graph.T_world = result.T_world;
  track_.T_world_lidar = result.T_world;
  for (size_t i = 0; i < loop_records_.size(); ++i) {
    LoopRecord& record = report.records[loop_records_[i]];
    record.weight = result.loop_weights[i];
    if (record.weight >= 0.5) continue;
    record.outcome = LoopOutcome::kDropped;
    record.reason = "the other loops contradict it";
  }
  report.polish_ms = watch.ElapsedMs();
  return true;
}

LoopCloser::LoopCloser(const LoopOptions& options, const Calibration& calibration,
                       std::shared_ptr<const KeyframeStore> store)
    : impl_((options.Check(), std::make_unique<Impl>(options, calibration, std::move(store)))) {}
LoopCloser::~LoopCloser() = default;

LoopUpdate LoopCloser::Process(const Keyframe& keyframe, const KeyframePayload& payload) {
  const Stopwatch watch;
  LoopTimes times;
  impl_->Add(keyframe, payload, &times);
  LoopUpdate update;
  update.last = impl_->last();
  const std::vector<double> linked_path_m = impl_->LinkedPathOf(update.last);
  impl_->Judge(impl_->Propose(update.last, linked_path_m, &times), linked_path_m, &times);
  if (impl_->Close(&times)) update.T_world_lidar = impl_->poses();
  update.connected = impl_->ConnectedTo(update.last);
  times.total_ms = watch.ElapsedMs();
  impl_->report.times.push_back(times);
  return update;
}

LoopUpdate LoopCloser::LookAgain(const std::function<bool()>& go_on) {
  LoopUpdate update;
  if (impl_->LookAgain(go_on)) update.T_world_lidar = impl_->poses();
  update.last = impl_->last();
  return update;
}

LoopUpdate LoopCloser::Polish() {
  LoopUpdate update;
  if (impl_->Polish()) update.T_world_lidar = impl_->poses();
  update.last = impl_->last();
  return update;
}

const LoopReport& LoopCloser::report() const { return impl_->report; }

}  // namespace tvl
