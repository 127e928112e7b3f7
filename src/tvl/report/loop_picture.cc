#include "tvl/report/loop_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tvl/report/canvas.h"
#include "tvl/report/top_view.h"

namespace tvl {
namespace {

const cv::Scalar& White() {
  static const cv::Scalar colour = cv::Scalar::all(255);
  return colour;
}

std::vector<Rigid3d> WorldPoses(const std::vector<Keyframe>& keyframes) {
  std::vector<Rigid3d> poses;
  for (const Keyframe& keyframe : keyframes) poses.push_back(keyframe.T_world_lidar);
  return poses;
}

void Line(TopView* view, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
          const cv::Scalar& colour, int width_px) {
  cv::line(view->canvas(), ShiftedPoint(view->Pixel(a.x(), a.y())),
           ShiftedPoint(view->Pixel(b.x(), b.y())), colour, width_px, cv::LINE_AA, kShift);
}

// Points of a stretch of keyframes round `centre`, above the road, seen from `T_view_world`.
void DrawStretch(const Map& map, int centre, const std::vector<Rigid3d>& T_world_lidar,
                 const Rigid3d& T_view_world, const cv::Scalar& colour, TopView* view) {
  constexpr int kEachWay = 12;
  constexpr double kAboveLidar_m = -1.2;  // leaves the road out
  const int last = static_cast<int>(T_world_lidar.size()) - 1;
  for (int k = std::max(0, centre - kEachWay); k <= std::min(last, centre + kEachWay); k += 3) {
    const auto cloud = map.store->Cloud(k);
    const Rigid3d T_view_lidar = T_view_world * T_world_lidar[static_cast<size_t>(k)];
    for (const FeatureCloud* part : {&cloud->planes, &cloud->edges}) {
      for (const Eigen::Vector3f& point : part->points) {
        if (point.z() < kAboveLidar_m) continue;
        const Eigen::Vector3d p = T_view_lidar * point.cast<double>();
        view->Dot(p.x(), p.y(), colour);
      }
    }
  }
}

cv::Mat DrawSide(const Map& map, const LoopProposal& loop,
                 const std::vector<Rigid3d>& T_world_lidar, const std::string& caption) {
  constexpr int kSide_px = 700;
  constexpr double kReach_m = 30.0;
  TopView view({kSide_px, kSide_px}, kSide_px / (2.0 * kReach_m), {kReach_m, kReach_m},
               TopView::Orientation::kForwardUp);
  const Rigid3d T_view_world = T_world_lidar[static_cast<size_t>(loop.history)].Inverse();
  const cv::Scalar blue(255, 170, 60), orange(40, 140, 255);
  DrawStretch(map, loop.history, T_world_lidar, T_view_world, blue, &view);
  DrawStretch(map, loop.current, T_world_lidar, T_view_world, orange, &view);
  view.ScaleBar(10.0);
  return WithLegend(view.canvas(), caption,
                    {{blue, "keyframe " + std::to_string(loop.history)},
                     {orange, "keyframe " + std::to_string(loop.current)}});
}

}  // namespace

cv::Mat DrawLoops(const std::vector<Keyframe>& keyframes, const LoopReport& report) {
  const std::vector<Rigid3d> before = WorldPoses(WithoutLoops(keyframes));
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < keyframes.size(); ++i) {
    for (const Eigen::Vector3d& p : {keyframes[i].T_world_lidar.t(), before[i].t()}) {
      low = low.cwiseMin(p.head<2>());
      high = high.cwiseMax(p.head<2>());
    }
  }
  const Eigen::Vector2d size_m = high - low + Eigen::Vector2d(20.0, 20.0);
  const double scale = std::min({1600.0 / size_m.x(), 1200.0 / size_m.y(), 12.0});
  const cv::Size size(std::max(320, static_cast<int>(size_m.x() * scale)),
                      std::max(200, static_cast<int>(size_m.y() * scale)));
  TopView view(size, scale, {low.x() - 10.0, high.y() + 10.0}, TopView::Orientation::kEastRight);
  const cv::Scalar grey = cv::Scalar::all(130), green(60, 220, 60), red(60, 60, 255);
  for (size_t i = 1; i < keyframes.size(); ++i) {
    Line(&view, before[i - 1].t(), before[i].t(), grey, 1);
    Line(&view, keyframes[i - 1].T_world_lidar.t(), keyframes[i].T_world_lidar.t(), White(), 1);
  }
  int accepted = 0;
  for (const LoopRecord& record : report.records) {
    const bool is_accepted = record.outcome == LoopOutcome::kAccepted;
    if (!is_accepted && record.outcome != LoopOutcome::kDropped) continue;
    accepted += is_accepted;
    const Eigen::Vector3d& a =
        keyframes[static_cast<size_t>(record.proposal.history)].T_world_lidar.t();
    const Eigen::Vector3d& b =
        keyframes[static_cast<size_t>(record.proposal.current)].T_world_lidar.t();
    Line(&view, a, b, is_accepted ? green : red, 3);
  }
  view.ScaleBar(size_m.x() > 400.0 ? 100.0 : 10.0);
  return WithLegend(
      view.canvas(), std::to_string(accepted) + " loops",
      {{grey, "odometry"}, {White(), "with loops"}, {green, "loops"}, {red, "dropped in the end"}});
}

std::vector<size_t> MostTelling(const std::vector<Keyframe>& keyframes, const LoopReport& report,
                                size_t count) {
  constexpr double kApart_m = 60.0;
  const std::vector<Rigid3d> before = WorldPoses(WithoutLoops(keyframes));
  std::vector<std::pair<double, size_t>> moved;  // by how much, m
  for (size_t i = 0; i < report.records.size(); ++i) {
    const LoopProposal& p = report.records[i].proposal;
    if (report.records[i].outcome != LoopOutcome::kAccepted) continue;
    const auto h = static_cast<size_t>(p.history), c = static_cast<size_t>(p.current);
    const Rigid3d T_before = before[h].Inverse() * before[c];
    const Rigid3d T_after = keyframes[h].T_world_lidar.Inverse() * keyframes[c].T_world_lidar;
    moved.emplace_back((T_before.t() - T_after.t()).norm(), i);
  }
  std::sort(moved.rbegin(), moved.rend());
  std::vector<size_t> chosen;
  for (const auto& candidate : moved) {
    const size_t i = candidate.second;
    const auto position = [&](size_t record) -> const Eigen::Vector3d& {
      const int current = report.records[record].proposal.current;
      return keyframes[static_cast<size_t>(current)].T_world_lidar.t();
    };
    const bool is_apart = std::all_of(chosen.begin(), chosen.end(), [&](size_t other) {
      return (position(other) - position(i)).norm() > kApart_m;
    });
    if (is_apart && chosen.size() < count) chosen.push_back(i);
  }
  return chosen;
}

cv::Mat DrawPlace(const Map& map, const LoopRecord& loop) {
  const std::vector<Rigid3d> before = WorldPoses(WithoutLoops(map.keyframes));
  const std::vector<Rigid3d> after = WorldPoses(map.keyframes);
  cv::Mat both;
  cv::hconcat(DrawSide(map, loop.proposal, before, "before"),
              DrawSide(map, loop.proposal, after, "after"), both);
  return both;
}

}  // namespace tvl
