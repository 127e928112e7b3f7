#include "tvl/sim/lane_pose.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace tvl::sim {

using Eigen::Vector2d;
using Eigen::Vector3d;

LanePoses::LanePoses(const Route& route, const Terrain& terrain, const StreetProfile& profile)
    : route_(route), terrain_(terrain), profile_(profile), axes_(route.axes, 16.0) {}

Vector2d LanePoses::Beside(double way_m, double left_m) const {
  const Vector2d t = route_.lane.Tangent(way_m);
  return route_.lane.At(way_m) + left_m * Vector2d(-t.y(), t.x());
}

Rigid3d LanePoses::At(double way_m, double left_m, bool is_reversed) const {
  const Vector2d t = route_.lane.Tangent(way_m);
  const Vector2d p = Beside(way_m, left_m);
  const Vector2d heading = is_reversed ? Vector2d(-t) : t;
  const double z = terrain_.Height(p) + ProfileHeight(profile_, std::min(10.0, axes_.Distance(p)));
  const Vector3d up = terrain_.Normal(p);
  Eigen::Matrix3d R;
  R.col(0) = (Vector3d(heading.x(), heading.y(), 0) - up * up.head<2>().dot(heading)).normalized();
  R.col(2) = up;
  R.col(1) = up.cross(R.col(0));
  return {Eigen::Quaterniond(R), Vector3d(p.x(), p.y(), z)};
}

}  // namespace tvl::sim
