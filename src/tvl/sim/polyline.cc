#include "tvl/sim/polyline.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;

Vector2d Left(const Vector2d& direction) { return {-direction.y(), direction.x()}; }

}  // namespace

Polyline::Polyline(std::vector<Vector2d> points) : points_(std::move(points)) {
  TVL_CHECK(points_.size() >= 2) << "a line needs two points";
  s_.reserve(points_.size());
  s_.push_back(0.0);
  for (size_t i = 1; i < points_.size(); ++i) {
    s_.push_back(s_.back() + (points_[i] - points_[i - 1]).norm());
  }
  TVL_CHECK(s_.back() > 0.0) << "a line needs a length";
}

Vector2d Polyline::At(double s_m) const {
  const auto next = std::upper_bound(s_.begin() + 1, s_.end() - 1, s_m);
  const auto i = static_cast<size_t>(next - s_.begin());
  const double share = (s_m - s_[i - 1]) / std::max(1e-12, s_[i] - s_[i - 1]);
  return points_[i - 1] + share * (points_[i] - points_[i - 1]);
}

Vector2d Polyline::Tangent(double s_m) const {
  return (At(s_m + 1.0) - At(s_m - 1.0)).normalized();
}

Polyline Polyline::Resampled(double step_m) const {
  const auto steps = static_cast<int>(std::max(1.0, std::round(length_m() / step_m)));
  std::vector<Vector2d> points;
  for (int i = 0; i <= steps; ++i) points.push_back(At(length_m() * i / steps));
  return Polyline(std::move(points));
}

Polyline Polyline::Shifted(double left_m) const {
  std::vector<Vector2d> points;
  for (size_t i = 0; i < points_.size(); ++i) {
    points.push_back(points_[i] + left_m * Left(Tangent(s_[i])));
  }
  return Polyline(std::move(points));
}

Polyline Polyline::Extended(double by_m) const {
  std::vector<Vector2d> points = points_;
  points.insert(points.begin(), At(-by_m));
  points.push_back(At(length_m() + by_m));
  return Polyline(std::move(points));
}

Polyline RoundCorners(const std::vector<Vector2d>& corners, double radius_m, double step_m) {
  std::vector<Vector2d> points = {corners.front()};
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    const Vector2d in = (corners[i] - corners[i - 1]).normalized();
    const Vector2d out = (corners[i + 1] - corners[i]).normalized();
    const double turn = std::atan2(in.x() * out.y() - in.y() * out.x(), in.dot(out));
    if (std::abs(turn) < 1e-6) continue;
    const double room =
        0.45 * std::min((corners[i] - corners[i - 1]).norm(), (corners[i + 1] - corners[i]).norm());
    const double leg = std::min(room, radius_m * std::tan(0.5 * std::abs(turn)));
    const double radius = leg / std::tan(0.5 * std::abs(turn));
    const Vector2d start = corners[i] - leg * in;
    const Vector2d to_centre = (turn > 0 ? 1.0 : -1.0) * Left(in);
    const int arcs = std::max(4, static_cast<int>(std::ceil(radius * std::abs(turn) / step_m)));
    for (int k = 0; k <= arcs; ++k) {
      const double angle = turn * k / arcs;
      points.push_back(start + radius * to_centre * (1.0 - std::cos(angle)) +
                       radius * in * std::sin(std::abs(angle)));
    }
  }
  points.push_back(corners.back());
  return Polyline(std::move(points)).Resampled(step_m);
}

PolylineIndex::PolylineIndex(std::vector<Polyline> lines, double reach_m)
    : lines_(std::move(lines)), reach_m_(reach_m), cell_m_(std::max(4.0, reach_m)) {
  TVL_CHECK(!lines_.empty()) << "no lines to search";
  Vector2d low = lines_[0].points()[0], high = low;
  for (const Polyline& line : lines_) {
    for (const Vector2d& p : line.points()) low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  origin_ = low.array() - 2.0 * reach_m_;
  columns_ = static_cast<int>((high.x() - origin_.x() + 2.0 * reach_m_) / cell_m_) + 1;
  rows_ = static_cast<int>((high.y() - origin_.y() + 2.0 * reach_m_) / cell_m_) + 1;
  cells_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
  for (size_t l = 0; l < lines_.size(); ++l) {
    const auto& points = lines_[l].points();
    for (size_t i = 0; i + 1 < points.size(); ++i) {
      const Vector2d a = points[i].cwiseMin(points[i + 1]), b = points[i].cwiseMax(points[i + 1]);
      const auto cell = [&](double v, double o) { return static_cast<int>((v - o) / cell_m_); };
      for (int y = cell(a.y() - reach_m_, origin_.y()); y <= cell(b.y() + reach_m_, origin_.y());
           ++y) {
        for (int x = cell(a.x() - reach_m_, origin_.x()); x <= cell(b.x() + reach_m_, origin_.x());
             ++x) {
          cells_[static_cast<size_t>(y) * static_cast<size_t>(columns_) + static_cast<size_t>(x)]
              .push_back({static_cast<int>(l), i});
        }
      }
    }
  }
}

PolylineHit PolylineIndex::Nearest(const Vector2d& p) const {
  PolylineHit best;
  const double fx = (p.x() - origin_.x()) / cell_m_, fy = (p.y() - origin_.y()) / cell_m_;
  if (fx < 0.0 || fy < 0.0 || fx >= columns_ || fy >= rows_) return best;
  const auto& cell =
      cells_[static_cast<size_t>(fy) * static_cast<size_t>(columns_) + static_cast<size_t>(fx)];
  double best_sq = reach_m_ * reach_m_;
  for (const Segment& segment : cell) {
    const Polyline& line = lines_[static_cast<size_t>(segment.line)];
    const Vector2d &a = line.points()[segment.point], &b = line.points()[segment.point + 1];
    const Vector2d ab = b - a;
    const double share = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
    const double distance_sq = (p - a - share * ab).squaredNorm();
    if (distance_sq >= best_sq) continue;
    best_sq = distance_sq;
    best = {std::sqrt(distance_sq), segment.line, line.s_m()[segment.point] + share * ab.norm()};
  }
  return best;
}

}  // namespace tvl::sim
