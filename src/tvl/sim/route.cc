#include "tvl/sim/route.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr uint64_t kRouteStream = 201, kSideStreetStream = 202, kRoadStream = 203;
constexpr double kSampling_m = 0.5;

// Gently bends a street grid, so that streets are no rulers.
class Bend {
 public:
  explicit Bend(Rng* rng) {
    for (Vector2d& phase : phases_) phase = {rng->Uniform(0, 2 * kPi), rng->Uniform(0, 2 * kPi)};
  }
  Vector2d operator()(const Vector2d& p) const {
    constexpr double kAmplitude_m = 7.0, kLong = 2 * kPi / 320.0, kShort = 2 * kPi / 190.0;
    return p + kAmplitude_m * Vector2d(std::sin(kLong * p.y() + phases_[0].x()) +
                                           0.5 * std::sin(kShort * p.y() + phases_[1].x()),
                                       std::sin(kLong * p.x() + phases_[0].y()) +
                                           0.5 * std::sin(kShort * p.x() + phases_[1].y()));
  }

 private:
  Vector2d phases_[2];
};

Polyline Bent(const Polyline& line, const Bend& bend) {
  const Polyline even = line.Resampled(kSampling_m);
  std::vector<Vector2d> points;
  for (const Vector2d& p : even.points()) points.push_back(bend(p));
  return Polyline(std::move(points)).Resampled(kSampling_m);
}

// A self-avoiding walk over a street grid with blocks of uneven size, `scale` times those of a
// town.
std::vector<Vector2d> WalkTown(double length_m, double scale, Rng* rng) {
  constexpr int kLines = 400;
  std::vector<double> x = {0.0}, y = {0.0};
  for (int i = 0; i < 2 * kLines; ++i) {
    x.push_back(x.back() + scale * rng->Uniform(75.0, 150.0));
    y.push_back(y.back() + scale * rng->Uniform(75.0, 150.0));
  }
  Vector2i node(kLines, kLines), step(1, 0);
  std::set<std::pair<int, int>> visited = {{node.x(), node.y()}};
  const auto place = [&](const Vector2i& n) {
    return Vector2d(x[static_cast<size_t>(n.x())] - x[kLines],
                    y[static_cast<size_t>(n.y())] - y[kLines]);
  };
  std::vector<Vector2d> corners = {place(node)};
  for (double length = 0.0; length < length_m;) {
    const Vector2i left(-step.y(), step.x());
    const Vector2i choices[3] = {step, left, -left};
    double weights[3] = {0.45, 0.275, 0.275};
    double total = 0.0;
    for (int c = 0; c < 3; ++c) {
      const Vector2i next = node + choices[c];
      if (visited.count({next.x(), next.y()}) > 0) weights[c] *= 0.02;
      total += weights[c];
    }
    double draw = rng->Uniform() * total;
    int choice = 0;
    while (choice < 2 && draw >= weights[choice]) draw -= weights[choice++];
    step = choices[choice];
    node += step;
    visited.insert({node.x(), node.y()});
    corners.push_back(place(node));
    length += (corners.back() - corners[corners.size() - 2]).norm();
  }
  return corners;
}

// Around and around a block of the given perimeter, starting in the middle of a side.
std::vector<Vector2d> AroundBlock(double perimeter_m, Rng* rng) {
  const double share = rng->Uniform(0.35, 0.65);  // of half the perimeter, for the first side
  const double a = 0.5 * perimeter_m * share, b = 0.5 * perimeter_m * (1.0 - share);
  const double side = rng->Uniform() < 0.5 ? 1.0 : -1.0;  // left or right turns
  const Vector2d low(0.5 * a, 0), far(0.5 * a, side * b), back(-0.5 * a, side * b),
      near(-0.5 * a, 0);
  return {{0, 0}, low, far, back, near, low, far, back, near, low, far, back, near, {0.3 * a, 0}};
}

// Along a street, around a block at its end, and after back_m along the street again, the other
// way.
std::vector<Vector2d> OutAndBack(double back_m, double travel_m, Rng* rng) {
  const double block = std::clamp(0.12 * back_m, 40.0, 110.0);
  const double out = std::max(30.0, back_m - 4.0 * block);
  const double side = rng->Uniform() < 0.5 ? 1.0 : -1.0;
  const double behind = std::max(out, travel_m - back_m);
  return {{0, 0},
          {out, 0},
          {out + block, 0},
          {out + block, side * block},
          {out, side * block},
          {out, 0},
          {out - behind, 0}};
}

// To and fro along parallel streets of equal spacing.
std::vector<Vector2d> Serpentine(double length_m) {
  constexpr double kStreet_m = 240.0, kSpacing_m = 60.0;
  std::vector<Vector2d> corners = {{0, 0}};
  double length = 0.0;
  for (int row = 0; length < length_m; ++row) {
    const double x = row % 2 == 0 ? kStreet_m : 0.0;
    corners.emplace_back(x, row * kSpacing_m);
    corners.emplace_back(x, (row + 1) * kSpacing_m);
    length += kStreet_m + kSpacing_m;
  }
  return corners;
}

std::vector<Vector2d> Corners(const std::string& preset, double travel_m, double closing_m,
                              Rng* rng) {
  if (preset == "loop" || preset == "nightloop" || preset == "lateloop") {
    return AroundBlock(closing_m, rng);
  }
  if (preset == "reverse") return OutAndBack(closing_m, travel_m, rng);
  if (preset == "aliasing") return Serpentine(travel_m);
  if (preset == "tunnel") return {{0, 0}, {travel_m, 0}};
  return WalkTown(travel_m, preset == "open" ? 4.0 : 1.0, rng);
}

// Side streets of 45-70 m to either side, every 70-130 m.
void AddSideStreets(uint64_t seed, Route* route) {
  Rng rng(seed, kSideStreetStream);
  const Polyline axis = route->axes.front();
  for (double s = rng.Uniform(20.0, 60.0); s < axis.length_m(); s += rng.Uniform(70.0, 130.0)) {
    if (s > route->tunnel_begin_m - 15.0 && s < route->tunnel_end_m + 15.0) continue;
    const Vector2d start = axis.At(s), t = axis.Tangent(s);
    const double side = rng.Uniform() < 0.5 ? 1.0 : -1.0, angle = rng.Uniform(-0.3, 0.3);
    const Vector2d n = side * Vector2d(-t.y(), t.x());
    const Vector2d direction = std::cos(angle) * n + std::sin(angle) * t;
    route->axes.emplace_back(
        Polyline({start, Vector2d(start + rng.Uniform(45.0, 70.0) * direction)})
            .Resampled(kSampling_m));
  }
}

// A line through the origin along x there, from its curvature (1/m, to the left) by distance.
template <typename Curvature>
Polyline LineOfCurvature(double behind_m, double ahead_m, const Curvature& curvature) {
  const auto walk = [&](double length_m, double sign) {
    std::vector<Vector2d> points = {Vector2d::Zero()};
    double heading = 0.0;
    for (double s = 0.0; s < length_m; s += kSampling_m) {
      const double turn = sign * kSampling_m * curvature(sign * (s + 0.5 * kSampling_m));
      const double middle = heading + 0.5 * turn;
      points.push_back(points.back() +
                       sign * kSampling_m * Vector2d(std::cos(middle), std::sin(middle)));
      heading += turn;
    }
    return points;
  };
  const std::vector<Vector2d> back = walk(behind_m, -1.0), ahead = walk(ahead_m, 1.0);
  std::vector<Vector2d> points(back.rbegin(), back.rend());
  points.insert(points.end(), ahead.begin() + 1, ahead.end());
  return Polyline(std::move(points));
}

// Where along a line it comes nearest to a point.
double NearestWay_m(const Polyline& line, const Vector2d& p) {
  size_t best = 0;
  for (size_t i = 0; i < line.points().size(); ++i) {
    if ((line.points()[i] - p).squaredNorm() < (line.points()[best] - p).squaredNorm()) best = i;
  }
  return line.s_m()[best];
}

// A stop before about every fifth corner sharper than 45 degrees.
std::vector<double> ChooseStops(const Polyline& lane, Rng* rng) {
  std::vector<double> stops;
  for (double s = 20.0; s < lane.length_m(); s += 1.0) {
    const double cosine = lane.Tangent(s).dot(lane.Tangent(s + 12.0));
    if (cosine > std::cos(kPi / 4)) continue;
    if (rng->Uniform() < 0.2) stops.push_back(s - 2.0);
    s += 30.0;
  }
  return stops;
}

}  // namespace

double Route::ShiftAt(double way_m) const {
  if (shift_m == 0.0) return 0.0;
  const double x = (way_m - shift_begin_m) / (shift_end_m - shift_begin_m);
  const double share = std::clamp(x, 0.0, 1.0);
  return shift_m * share * share * (3.0 - 2.0 * share);
}

Route ShiftedFrom(Route route, double way_m, double left_m) {
  constexpr double kChange_m = 40.0;
  route.shift_m = left_m;
  route.shift_begin_m = way_m - kChange_m, route.shift_end_m = way_m;
  std::vector<Vector2d> points;
  for (const double s : route.lane.s_m()) {
    const Vector2d t = route.lane.Tangent(s);
    points.push_back(route.lane.At(s) + route.ShiftAt(s) * Vector2d(-t.y(), t.x()));
  }
  route.lane = Polyline(std::move(points)).Resampled(kSampling_m);
  return route;
}

Route PlanRoute(const std::string& preset, uint64_t seed, double travel_m, double closing_m) {
  Rng rng(seed, kRouteStream);
  const bool is_straight = preset == "aliasing" || preset == "tunnel";
  const std::vector<Vector2d> corners = Corners(preset, travel_m, closing_m, &rng);
  double radius_m = is_straight ? 9.0 : rng.Uniform(9.0, 12.0);
  if (preset == "open") radius_m = 120.0;  // a country road
  const Polyline grid = RoundCorners(corners, radius_m, kSampling_m);
  const Polyline axis = is_straight ? grid : Bent(grid, Bend(&rng));
  Route route;
  route.lane = axis.Shifted(-kLaneOffset_m).Resampled(kSampling_m);
  route.axes.push_back(axis.Extended(60.0).Resampled(kSampling_m));
  if (preset == "tunnel") {
    route.tunnel_begin_m = 60.0, route.tunnel_end_m = 260.0;
    route.stops_m = {150.0 + rng.Uniform(0.0, 40.0)};
    return route;
  }
  if (preset == "open") return route;
  route.stops_m = ChooseStops(route.lane, &rng);
  if (preset != "aliasing") AddSideStreets(seed, &route);
  return route;
}

double BendRadius_m(double speed_m_s) {
  constexpr double kAcross_m_s2 = 2.5, kSmallest_m = 20.0;
  return std::max(kSmallest_m, speed_m_s * speed_m_s / kAcross_m_s2);
}

Route PlanRoad(uint64_t seed, const RoadOptions& o) {
  // 75 degrees of bend on both sides of the start, easing in and out over a fifth of that.
  constexpr double kHalfBend_rad = 1.3, kEasing = 0.2;
  Rng rng(seed, kRoadStream);
  const double sign = rng.Uniform() < 0.5 ? 1.0 : -1.0;
  const double half_m = kHalfBend_rad * o.bend_radius_m;
  const double phase = rng.Uniform(0.0, 2.0 * kPi);
  const auto curvature = [&](double s) {
    constexpr double kWinding_m = 1200.0;
    if (o.winding_radius_m > 0.0) {
      return std::sin(2.0 * kPi * s / kWinding_m + phase) / o.winding_radius_m;
    }
    if (o.bend_radius_m == 0.0) return 0.0;
    const double left_m = half_m - std::abs(s);
    return sign / o.bend_radius_m * std::clamp(left_m / (kEasing * half_m), 0.0, 1.0);
  };
  const Polyline axis = LineOfCurvature(std::max(o.behind_m, half_m + 100.0), o.ahead_m, curvature);
  Route route;
  route.lane = axis.Shifted(-kLaneOffset_m).Resampled(kSampling_m);
  route.start_m = NearestWay_m(route.lane, {0.0, -kLaneOffset_m});
  route.axes.push_back(axis.Extended(60.0).Resampled(kSampling_m));
  // In a narrow bend they would run into the street itself.
  if (o.has_side_streets && o.bend_radius_m == 0.0) AddSideStreets(seed, &route);
  return route;
}

Route RouteAlong(const Polyline& lane, uint64_t seed) {
  Route route;
  route.lane = lane.Resampled(kSampling_m);
  route.axes.push_back(route.lane.Shifted(kLaneOffset_m).Extended(60.0).Resampled(kSampling_m));
  AddSideStreets(seed, &route);
  return route;
}

}  // namespace tvl::sim
