#include "tvl/sim/drive.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/sim/lane_presets.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Others in the lane are up to this long ahead; they need a road to drive on.
constexpr double kAhead_s = 30.0;
// Control poses before frame 0 and after the last: sweeps and splines reach over the ends.
constexpr int kSpareFrames = 4;
// KITTI's poses jitter from frame to frame; this much smoothing leaves the vehicle's motion.
constexpr double kSmoothing_frames = 1.5;
constexpr double kOverlap_frames = 20;  // of lateloop

VehicleOptions VehicleFor(const SimOptions& options) {
  VehicleOptions vehicle;
  if (options.preset == "tunnel" || !options.tunnel.IsEmpty()) vehicle.tunnel_variation = 0.3;
  if (options.preset == "open") vehicle.cruise_m_s = 14.0;
  vehicle.faster_after_stop = options.faster;
  const double speed_m_s =
      options.preset == "highway" ? HighwaySpeed_m_s(options) : options.speed_m_s;
  if (speed_m_s > 0.0) {
    vehicle.cruise_m_s = speed_m_s;
    vehicle.variation = 0.05;                                // +-1 %: a speed held
    vehicle.lateral_m_s2 = 3.0;                              // the bends are made for the speed
    vehicle.roughness_m *= std::min(1.0, 11.0 / speed_m_s);  // fast roads are smoother
  }
  return vehicle;
}

// When the loop of a preset is to close.
double ClosingTime_s(const SimOptions& options) {
  double frame = 0.6 * options.frames;
  if (options.preset == "nightloop") frame = 0.5 * options.frames;
  if (options.preset == "lateloop") frame = options.frames - kOverlap_frames;
  return std::max(1.0, frame) * kFrameInterval_s;
}

// Way at which the lane first leads along a street it has led along before: in the same direction
// (sign 1) or the opposite one (-1). Its length if it never does.
double FirstRevisit_m(const Polyline& lane, double sign) {
  constexpr double kStep_m = 2.0, kSameStreet_m = 5.0, kApart_m = 60.0;
  std::vector<Vector2d> places, tangents;
  for (double s = 0.0; s < lane.length_m(); s += kStep_m) {
    const Vector2d p = lane.At(s), t = lane.Tangent(s);
    for (size_t i = 0; i < places.size(); ++i) {
      if (s - kStep_m * static_cast<double>(i) < kApart_m) break;
      if ((p - places[i]).norm() < kSameStreet_m && sign * t.dot(tangents[i]) > 0.9) return s;
    }
    places.push_back(p), tangents.push_back(t);
  }
  return lane.length_m();
}

struct PlannedRoute {
  Route route;
  TravelProfile travel;
};

double Duration_s(const SimOptions& options) {
  return options.frames * kFrameInterval_s + kAhead_s;
}

// Among the lanes of a jam, or standing between two of them.
PlannedRoute PlanInLanes(const SimOptions& options) {
  constexpr double kTick_s = 0.05;
  const double duration_s = options.frames * kFrameInterval_s;
  RoadOptions road;
  road.ahead_m = 350.0 + 3.0 * duration_s;
  road.winding_radius_m = 900.0;
  road.has_side_streets = false;  // their kerbs would reach into the wider road
  Route route = PlanRoad(options.seed, road);
  std::vector<double> way_m;
  const JamFlows jam = PlanJam(options.seed, duration_s);
  for (double t = 0.0; t < Duration_s(options); t += kTick_s) {
    way_m.push_back(route.start_m + (options.preset == "jam" ? jam.ego.Way_m(t) : 0.0));
  }
  return {std::move(route), TravelProfile(std::move(way_m), kTick_s)};
}

PlannedRoute PlanHighway(const SimOptions& options) {
  constexpr double kSight_m = 400.0;
  const VehicleOptions vehicle = VehicleFor(options);
  RoadOptions road;
  const double driven_m = options.frames * kFrameInterval_s * 1.02 * vehicle.cruise_m_s;
  road.ahead_m = kSight_m + std::max(kHighway_m, driven_m);
  road.winding_radius_m = 1500.0;  // 0.8 m/s^2 across at 35 m/s
  road.has_side_streets = false;
  Route route = PlanRoad(options.seed, road);
  TravelProfile travel(route, vehicle, options.seed, Duration_s(options));
  return {std::move(route), std::move(travel)};
}

// A road to begin at speed on.
PlannedRoute PlanAtSpeed(const SimOptions& options) {
  const VehicleOptions vehicle = VehicleFor(options);
  RoadOptions road;
  road.ahead_m = Duration_s(options) * 1.05 * vehicle.cruise_m_s + 50.0;
  if (options.is_turning) road.bend_radius_m = BendRadius_m(options.speed_m_s);
  road.has_side_streets = options.preset != "open";
  Route route = PlanRoad(options.seed, road);
  TravelProfile travel(route, vehicle, options.seed, Duration_s(options));
  return {std::move(route), std::move(travel)};
}

PlannedRoute PlanSized(const SimOptions& options, double closing_m) {
  const VehicleOptions vehicle = VehicleFor(options);
  const double duration_s = Duration_s(options);
  const double travel_m = duration_s * 1.25 * vehicle.cruise_m_s + 50.0;
  Route route = PlanRoute(options.preset, options.seed, travel_m, closing_m);
  TravelProfile travel(route, vehicle, options.seed, duration_s);
  return {std::move(route), std::move(travel)};
}

// How far the vehicle gets depends on corners and stops, and these on the size of the block: the
// size is searched for at which the loop closes when it should.
PlannedRoute PlanPreset(const SimOptions& options) {
  if (options.preset == "jam" || options.preset == "passing") return PlanInLanes(options);
  if (options.preset == "highway") return PlanHighway(options);
  if (options.speed_m_s > 0.0) return PlanAtSpeed(options);
  const double closing_s = ClosingTime_s(options);
  const bool is_loop = IsLoopPreset(options.preset);
  if (!is_loop && options.preset != "reverse") return PlanSized(options, 0.0);
  const auto closes_s = [&](double closing_m) {
    const PlannedRoute planned = PlanSized(options, closing_m);
    return planned.travel.TimeAt(FirstRevisit_m(planned.route.lane, is_loop ? 1.0 : -1.0));
  };
  // From too large downwards: of several sizes the largest, with the least of standing at corners.
  constexpr double kSmallest_m = 120.0;
  double closing_m = 12.0 * closing_s, step_m = 0.1 * closing_m;
  for (int round = 0; round < 4; ++round, step_m *= 0.25) {
    while (closing_m > kSmallest_m && closes_s(closing_m) > closing_s) closing_m -= step_m;
    if (round < 3) closing_m += step_m;
  }
  PlannedRoute planned = PlanSized(options, std::max(kSmallest_m, closing_m));
  if (options.lateral_m == 0.0) return planned;
  const double back_m = FirstRevisit_m(planned.route.lane, 1.0);
  Route route = ShiftedFrom(std::move(planned.route), back_m, options.lateral_m);
  TravelProfile travel(route, VehicleFor(options), options.seed, Duration_s(options));
  return {std::move(route), std::move(travel)};
}

std::vector<Rigid3d> DrivePreset(const PlannedRoute& planned, const Terrain& terrain,
                                 const SimOptions& options) {
  const Rigid3d T_vehicle_lidar = Rigid3d::Translation(0, 0, kLidarHeight_m);
  const VehicleOptions vehicle = VehicleFor(options);
  std::vector<Rigid3d> control;
  for (int k = -kSpareFrames; k < options.frames + kSpareFrames; ++k) {
    control.push_back(VehiclePose(planned.route, terrain, planned.travel, vehicle, options.seed,
                                  k * kFrameInterval_s) *
                      T_vehicle_lidar);
  }
  return control;
}

// Poses of the lidar in a level world whose x axis is the first heading.
std::vector<Rigid3d> ReadDriven(const SimOptions& options, const Rigid3d& T_cam0_lidar) {
  std::vector<Rigid3d> poses = ReadKittiPoses(options.trajectory_file);
  if (options.frames > 0 && poses.size() > static_cast<size_t>(options.frames)) {
    poses.resize(static_cast<size_t>(options.frames));
  }
  TVL_CHECK_INPUT(poses.size() >= 10)
      << options.trajectory_file << ": a drive needs 10 poses, has " << poses.size();
  Vector3d up = Vector3d::Zero();
  for (Rigid3d& T : poses) {
    T = T * T_cam0_lidar;
    up += T.q() * Vector3d::UnitZ();
  }
  // The car stands upright on average.
  const Vector3d z = up.normalized();
  const Vector3d forward = poses.front().q() * Vector3d::UnitX();
  const Vector3d x = (forward - z * z.dot(forward)).normalized();
  Eigen::Matrix3d R_file_world;
  R_file_world << x, z.cross(x), z;
  const Rigid3d T_world_file =
      Rigid3d(Eigen::Quaterniond(R_file_world), poses.front().t()).Inverse();
  for (Rigid3d& T : poses) T = T_world_file * T;
  return poses;
}

// Heights of a drive, climbing no steeper than streets do: where KITTI's truth was lost, its height
// runs away by metres (the first 100 frames of 08).
std::vector<Vector3d> WithoutCliffs(std::vector<Vector3d> points) {
  constexpr double kSteepest = 0.12;
  double z = points.front().z(), measured = z;
  for (size_t i = 1; i < points.size(); ++i) {
    const double limit = kSteepest * (points[i] - points[i - 1]).head<2>().norm();
    z += std::clamp(points[i].z() - measured, -limit, limit);
    measured = points[i].z();
    points[i].z() = z;
  }
  return points;
}

// The line driven, leaving out where the car stands, and the way along it at each pose.
struct DrivenLine {
  Polyline lane;
  std::vector<double> way_m;
};

DrivenLine LineOf(const std::vector<Rigid3d>& poses, const std::string& file) {
  std::vector<Vector2d> points = {poses.front().t().head<2>()};
  std::vector<double> way = {0.0};
  double length = 0.0;
  for (size_t i = 1; i < poses.size(); ++i) {
    const Vector2d p = poses[i].t().head<2>();
    const double step = (p - points.back()).norm();
    way.push_back(length + step);
    if (step < 0.5) continue;
    length += step;
    points.push_back(p);
  }
  TVL_CHECK_INPUT(points.size() >= 4) << file << ": the car hardly moves";
  return {Polyline(std::move(points)), std::move(way)};
}

Drive PlanAlongFile(const SimOptions& options, const Rigid3d& T_cam0_lidar) {
  std::vector<Rigid3d> poses = SmoothPoses(ReadDriven(options, T_cam0_lidar), kSmoothing_frames);
  std::vector<Vector3d> contact;
  for (const Rigid3d& T : poses) contact.push_back(T * Vector3d(0, 0, -kLidarHeight_m));
  contact = WithoutCliffs(std::move(contact));
  // As wide as a street: lanes side by side lie at one height.
  const std::vector<double> heights = ConsistentHeights(contact, 16.0);
  for (size_t i = 0; i < contact.size(); ++i) contact[i].z() = heights[i];
  const Terrain terrain = Terrain::Through(contact);
  for (size_t i = 0; i < poses.size(); ++i) {
    Vector3d t = poses[i].t();
    t.z() = terrain.Height(t.head<2>()) + kLidarHeight_m;
    poses[i] = Rigid3d(poses[i].q(), t);
  }
  DrivenLine line = LineOf(poses, options.trajectory_file);
  return {RouteAlong(line.lane, options.seed),
          terrain,
          TravelProfile(std::move(line.way_m), kFrameInterval_s),
          PoseSpline(ExtendPoses(poses, kSpareFrames), -kSpareFrames * kFrameInterval_s,
                     kFrameInterval_s),
          static_cast<int>(poses.size()),
          options.night,
          {},
          {},
          {}};
}

StreetProfile ProfileFor(const SimOptions& options) {
  if (options.preset == "jam" || options.preset == "passing") return FourLanes();
  return options.preset == "highway" ? Highway(options.road) : StreetProfile();
}

Drive PlanOwn(const SimOptions& options) {
  const bool is_flat = options.preset == "tunnel";
  const double steepness = options.preset == "highway" ? 0.3 : 1.0;  // built level
  const Terrain terrain = is_flat ? Terrain() : Terrain::Rolling(options.seed, steepness);
  PlannedRoute planned = PlanPreset(options);
  PoseSpline spline(DrivePreset(planned, terrain, options), -kSpareFrames * kFrameInterval_s,
                    kFrameInterval_s);
  FrameRange night = options.night;
  if (options.preset == "nightloop" && night.IsEmpty()) {
    night = {options.frames / 2, options.frames};
  }
  return {std::move(planned.route),
          terrain,
          std::move(planned.travel),
          std::move(spline),
          options.frames,
          night,
          {},
          {},
          ProfileFor(options)};
}

}  // namespace

Drive PlanDrive(const SimOptions& options, const Rigid3d& T_cam0_lidar) {
  Drive drive =
      options.trajectory_file.empty() ? PlanOwn(options) : PlanAlongFile(options, T_cam0_lidar);
  const auto way = [&](int frame) { return drive.travel.Way_m(frame * kFrameInterval_s); };
  if (!options.tunnel.IsEmpty()) {
    drive.route.tunnel_begin_m = way(options.tunnel.begin);
    drive.route.tunnel_end_m = std::max(way(options.tunnel.begin) + 1.0, way(options.tunnel.end));
  }
  if (options.preset == "highway") {
    const double begin_m = drive.route.start_m + kHighwayBefore_m;
    drive.bare_m.emplace_back(begin_m, begin_m + kHighwayBare_m);
  }
  if (!options.open.IsEmpty()) {
    drive.open_m.emplace_back(way(options.open.begin), way(options.open.end));
  }
  return drive;
}

}  // namespace tvl::sim
