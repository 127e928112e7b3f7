#include "tvl/sim/vehicle.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr uint64_t kSpeedStream = 301, kRoughnessStream = 302;
constexpr double kTick_s = 0.01;
constexpr double kGrid_m = 0.25;

// Heading change per metre around s.
double Curvature(const Polyline& line, double s_m) {
  const Vector2d a = line.Tangent(s_m - 1.5), b = line.Tangent(s_m + 1.5);
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b))) / 3.0;
}

bool IsAfterStop(const Route& route, double way_m) {
  return !route.stops_m.empty() && way_m > route.stops_m.front();
}

// What the driver would like to drive at each kGrid_m of the lane, bends and stops included.
std::vector<double> WantedSpeed(const Route& route, const VehicleOptions& o, Rng* rng) {
  const auto n = static_cast<size_t>(route.lane.length_m() / kGrid_m) + 1;
  std::vector<double> v(n);
  const double phase = rng->Uniform(0, 2 * kPi), phase2 = rng->Uniform(0, 2 * kPi);
  for (size_t i = 0; i < n; ++i) {
    const double s = kGrid_m * static_cast<double>(i);
    v[i] = o.cruise_m_s * (1.0 + o.variation * (0.12 * std::sin(s / 45.0 + phase) +
                                                0.08 * std::sin(s / 17.0 + phase2)));
    if (IsAfterStop(route, s)) v[i] *= 1.0 + o.faster_after_stop;
    if (s > route.tunnel_begin_m && s < route.tunnel_end_m) {
      v[i] *= 1.0 + o.tunnel_variation * std::sin(2.0 * kPi * (s - route.tunnel_begin_m) / 70.0);
    }
    v[i] = std::min(v[i], std::sqrt(o.lateral_m_s2 / std::max(1e-4, Curvature(route.lane, s))));
  }
  for (const double stop : route.stops_m) {
    const auto i = static_cast<size_t>(std::max(0.0, stop) / kGrid_m);
    if (i < n) v[i] = 0.0;
  }
  return v;
}

// The same within what the car can accelerate and brake.
std::vector<double> DrivenSpeed(std::vector<double> v, const Route& route,
                                const VehicleOptions& o) {
  for (size_t i = 1; i < v.size(); ++i) {
    double rate = o.acceleration_m_s2;
    if (IsAfterStop(route, kGrid_m * static_cast<double>(i))) rate *= 1.0 + o.faster_after_stop;
    v[i] = std::min(v[i], std::sqrt(v[i - 1] * v[i - 1] + 2 * rate * kGrid_m));
  }
  for (size_t i = v.size() - 1; i-- > 0;) {
    v[i] = std::min(v[i], std::sqrt(v[i + 1] * v[i + 1] + 2 * o.braking_m_s2 * kGrid_m));
  }
  return v;
}

std::vector<double> SmoothWay(const std::vector<double>& way, int half_width) {
  // Two running means of equal width: a continuous acceleration.
  std::vector<double> smooth = way;
  const auto n = static_cast<int>(way.size());
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<double> sum(smooth.size() + 1, 0.0);
    for (size_t i = 0; i < smooth.size(); ++i) sum[i + 1] = sum[i] + smooth[i];
    for (int i = 0; i < n; ++i) {
      const int reach = std::min({half_width, i, n - 1 - i});
      smooth[static_cast<size_t>(i)] =
          (sum[static_cast<size_t>(i + reach + 1)] - sum[static_cast<size_t>(i - reach)]) /
          (2 * reach + 1);
    }
  }
  return smooth;
}

// Sum of sines of the way: what a road does to a car. Zero mean, amplitude about 1.
double Roughness(uint64_t seed, uint64_t channel, double way_m) {
  Rng rng(seed, kRoughnessStream + 16 * channel);
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) {
    const double wavelength_m = rng.Uniform(4.0, 30.0);
    sum += std::sin(2 * kPi * way_m / wavelength_m + rng.Uniform(0, 2 * kPi));
  }
  return sum / std::sqrt(6.0);
}

}  // namespace

TravelProfile::TravelProfile(const Route& route, const VehicleOptions& options, uint64_t seed,
                             double duration_s)
    : interval_s_(kTick_s) {
  Rng rng(seed, kSpeedStream);
  const std::vector<double> v = DrivenSpeed(WantedSpeed(route, options, &rng), route, options);
  const double end_s = duration_s + 2.0;
  double s = route.start_m, pause_s = 0.0;
  for (double t = 0.0; t <= end_s; t += kTick_s) {
    way_m_.push_back(s);
    if (pause_s > 0.0) {
      pause_s -= kTick_s;
      continue;
    }
    const double f = std::min(s / kGrid_m, static_cast<double>(v.size()) - 1.001);
    const auto i = static_cast<size_t>(f);
    const double share = f - static_cast<double>(i);
    const double speed = std::max(0.25, (1.0 - share) * v[i] + share * v[i + 1]);
    // A stop is passed once, after a wait.
    const auto next = static_cast<size_t>((s + speed * kTick_s) / kGrid_m);
    if (next != i && next < v.size() && v[next] == 0.0) pause_s = rng.Uniform(1.5, 4.0);
    s += speed * kTick_s;
  }
  way_m_ = SmoothWay(way_m_, 25);
}

TravelProfile::TravelProfile(std::vector<double> way_m, double interval_s)
    : interval_s_(interval_s), way_m_(std::move(way_m)) {
  TVL_CHECK(way_m_.size() >= 2 && interval_s_ > 0.0) << "a way needs two instants";
}

double TravelProfile::Way_m(double time_s) const {
  const double f =
      std::clamp(time_s / interval_s_, 0.0, static_cast<double>(way_m_.size()) - 1.001);
  const auto i = static_cast<size_t>(f);
  return way_m_[i] + (time_s / interval_s_ - static_cast<double>(i)) * (way_m_[i + 1] - way_m_[i]);
}

double TravelProfile::Speed_m_s(double time_s) const {
  return (Way_m(time_s + 0.05) - Way_m(time_s - 0.05)) / 0.1;
}

double TravelProfile::TimeAt(double way_m) const {
  const auto at = std::lower_bound(way_m_.begin(), way_m_.end(), way_m);
  return interval_s_ * static_cast<double>(at - way_m_.begin());
}

Rigid3d VehiclePose(const Route& route, const Terrain& terrain, const TravelProfile& travel,
                    const VehicleOptions& o, uint64_t seed, double time_s) {
  const double way = travel.Way_m(time_s);
  const double dt = 0.2;
  const double along = (travel.Speed_m_s(time_s + dt) - travel.Speed_m_s(time_s - dt)) / (2 * dt);
  const Vector2d p = route.lane.At(way);
  // A car is as long as it is: its heading averages the lane's over its wheelbase.
  const Vector2d heading = (route.lane.At(way + 1.4) - route.lane.At(way - 1.4)).normalized();
  const Vector2d before = route.lane.Tangent(way - 1.5), after = route.lane.Tangent(way + 1.5);
  const double turn =
      std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after)) / 3.0;
  const double speed = travel.Speed_m_s(time_s);

  const Vector3d up = terrain.Normal(p);
  const Vector3d forward =
      (Vector3d(heading.x(), heading.y(), 0) - up * up.head<2>().dot(heading)).normalized();
  Eigen::Matrix3d R;
  R << forward, up.cross(forward), up;
  const double pitch = -o.pitch_per_m_s2 * along + 0.35 * o.roughness_m * Roughness(seed, 1, way);
  const double roll =
      o.roll_per_m_s2 * speed * speed * turn + 0.45 * o.roughness_m * Roughness(seed, 2, way);
  const double heave = o.roughness_m * Roughness(seed, 3, way);
  const Eigen::Quaterniond q = Eigen::Quaterniond(R) * Eigen::AngleAxisd(pitch, Vector3d::UnitY()) *
                               Eigen::AngleAxisd(roll, Vector3d::UnitX());
  return {q, Vector3d(p.x(), p.y(), terrain.Height(p) + heave)};
}

}  // namespace tvl::sim
