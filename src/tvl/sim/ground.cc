#include "tvl/sim/ground.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kFineCell_m = 1.5;  // resolves kerbs at crossings
constexpr double kCoarseCell_m = 12.0;
constexpr double kCoarseMargin_m = 160.0;  // the lidar sees 80-120 m
constexpr double kCoarseDrop_m = 0.35;     // keeps the coarse sheet below the fine one

// A corner of a piece of ground: where it is and how far from the nearest axis.
struct Corner {
  Vector3d p;  // z: terrain only
  double distance_m;
};
using Piece = std::vector<Corner>;

// Distance from the nodes of a regular grid to the nearest axis, up to reach_m.
class DistanceGrid {
 public:
  DistanceGrid(const std::vector<Polyline>& axes, double reach_m) : reach_m_(reach_m) {
    Vector2d low = axes[0].points()[0], high = low;
    for (const Polyline& axis : axes) {
      for (const Vector2d& p : axis.points()) low = low.cwiseMin(p), high = high.cwiseMax(p);
    }
    const double margin = reach_m_ + 2.0 * kFineCell_m;
    origin_ = low.array() - margin;
    columns_ = static_cast<int>((high.x() - low.x() + 2 * margin) / kFineCell_m) + 2;
    rows_ = static_cast<int>((high.y() - low.y() + 2 * margin) / kFineCell_m) + 2;
    distance_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_),
                     static_cast<float>(reach_m_ + 1.0));
    for (const Polyline& axis : axes) {
      for (size_t i = 0; i + 1 < axis.points().size(); ++i) {
        AddSegment(axis.points()[i], axis.points()[i + 1]);
      }
    }
  }

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Vector2d Place(int x, int y) const { return origin_ + kFineCell_m * Vector2d(x, y); }
  double At(int x, int y) const {
    return distance_[static_cast<size_t>(y) * static_cast<size_t>(columns_) +
                     static_cast<size_t>(x)];
  }

 private:
  void AddSegment(const Vector2d& a, const Vector2d& b) {
    const Vector2d ab = b - a;
    const auto first = [&](double v) { return std::max(0, static_cast<int>(v / kFineCell_m)); };
    const Vector2d low = a.cwiseMin(b).array() - reach_m_ - origin_.array();
    const Vector2d high = a.cwiseMax(b).array() + reach_m_ - origin_.array();
    const int x_end = std::min(columns_ - 1, static_cast<int>(high.x() / kFineCell_m) + 1);
    const int y_end = std::min(rows_ - 1, static_cast<int>(high.y() / kFineCell_m) + 1);
    for (int y = first(low.y()); y <= y_end; ++y) {
      for (int x = first(low.x()); x <= x_end; ++x) {
        const Vector2d p = Place(x, y);
        const double share = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
        float& d = distance_[static_cast<size_t>(y) * static_cast<size_t>(columns_) +
                             static_cast<size_t>(x)];
        d = std::min(d, static_cast<float>((p - a - share * ab).norm()));
      }
    }
  }

  double reach_m_;
  Vector2d origin_;
  int columns_ = 0, rows_ = 0;
  std::vector<float> distance_;
};

struct Split {
  Piece near, far;
  Piece border;  // two corners where the level crosses, or empty
};

Split SplitAt(const Piece& piece, double level_m) {
  Split split;
  for (size_t i = 0; i < piece.size(); ++i) {
    const Corner &a = piece[i], &b = piece[(i + 1) % piece.size()];
    (a.distance_m < level_m ? split.near : split.far).push_back(a);
    if ((a.distance_m < level_m) == (b.distance_m < level_m)) continue;
    const double share = (level_m - a.distance_m) / (b.distance_m - a.distance_m);
    const Corner crossing{a.p + share * (b.p - a.p), level_m};
    split.near.push_back(crossing);
    split.far.push_back(crossing);
    split.border.push_back(crossing);
  }
  if (split.border.size() != 2) split.border.clear();
  return split;
}

// Small bumps of unpaved ground, 0 at its border with the pavement.
double Bumps(const Vector3d& p, double beyond_m) {
  const double fade = std::min(1.0, beyond_m / 2.0);
  return fade * (0.04 * std::sin(0.9 * p.x() + 0.4 * p.y()) * std::sin(0.7 * p.y() - 0.3 * p.x()) +
                 0.02 * std::sin(2.1 * p.x()) * std::sin(1.9 * p.y()));
}

class GroundBuilder {
 public:
  explicit GroundBuilder(const StreetProfile& profile) : profile_(profile) {}

  // Cuts a piece along the borders of the street's profile.
  void Add(const Piece& piece) {
    const Split road = SplitAt(piece, profile_.half_road_m);
    AddFlat(road.near, profile_.road, 0.0);
    if (!road.border.empty() && profile_.kerb_height_m > 0.0) AddKerbFace(road.border);
    if (road.far.size() < 3) return;
    const Split kerb = SplitAt(road.far, profile_.half_road_m + profile_.kerb_width_m);
    AddFlat(kerb.near, profile_.kerb, kAbove);
    if (kerb.far.size() < 3) return;
    const Split pavement = SplitAt(kerb.far, profile_.pavement_end_m);
    AddFlat(pavement.near, Material::kPavement, kAbove);
    AddFlat(pavement.far, Material::kGrass, kAbove);
  }

  Mesh TakeMesh() { return std::move(mesh_); }

 private:
  static constexpr double kAbove = 1e-6;  // on the far side of the kerb's face

  Vector3f Lift(const Corner& c, double offset_m) const {
    const double d = c.distance_m + offset_m;
    const double bumps = d > profile_.pavement_end_m
                             ? profile_.bumps * Bumps(c.p, d - profile_.pavement_end_m)
                             : 0.0;
    return Vector3d(c.p.x(), c.p.y(), c.p.z() + ProfileHeight(profile_, d) + bumps).cast<float>();
  }

  void AddFlat(const Piece& piece, Material material, double offset_m) {
    if (piece.size() < 3) return;
    std::vector<Vector3f> corners;
    for (const Corner& c : piece) {
      // The road side of the kerb line must not take the height of the kerb.
      corners.push_back(Lift(c, offset_m > 0.0 ? offset_m : -1e-6));
    }
    mesh_.AddPolygon(corners, material);
  }

  void AddKerbFace(const Piece& border) {
    mesh_.AddQuad(Lift(border[0], -1e-6), Lift(border[1], -1e-6), Lift(border[1], kAbove),
                  Lift(border[0], kAbove), Material::kKerb);
  }

  StreetProfile profile_;
  Mesh mesh_;
};

// Coarse ground around everything, where no fine ground is.
void AddSurroundings(const DistanceGrid& grid, const Terrain& terrain, Mesh* mesh) {
  const Vector2d low = grid.Place(0, 0).array() - kCoarseMargin_m;
  const Vector2d high = grid.Place(grid.columns(), grid.rows()).array() + kCoarseMargin_m;
  const auto columns = static_cast<int>((high.x() - low.x()) / kCoarseCell_m);
  const auto rows = static_cast<int>((high.y() - low.y()) / kCoarseCell_m);
  const auto place = [&](int x, int y) -> Vector3f {
    const Vector2d p = low + kCoarseCell_m * Vector2d(x, y);
    return Vector3d(p.x(), p.y(), terrain.Height(p) - kCoarseDrop_m).cast<float>();
  };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      mesh->AddQuad(place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1),
                    Material::kGrass);
    }
  }
}

struct Dash {
  Vector2d place;
  int line;
  double s_m;
};

// Where several lines share a street, or one comes by again, only the first is painted.
bool IsPainted(const std::vector<Dash>& painted, const Dash& dash) {
  constexpr double kSameStreet_m = 6.0, kComesAgain_m = 30.0;
  return std::any_of(painted.begin(), painted.end(), [&](const Dash& other) {
    const bool is_neighbour = other.line == dash.line && dash.s_m - other.s_m < kComesAgain_m;
    return !is_neighbour && (other.place - dash.place).norm() < kSameStreet_m;
  });
}

}  // namespace

StreetProfile FourLanes() {
  StreetProfile profile;
  profile.half_road_m = 7.0;
  profile.pavement_end_m = 9.2;
  profile.lines_m = {-kLaneWidth_m, 0.0, kLaneWidth_m};
  return profile;
}

StreetProfile Highway(RoadSurface surface) {
  StreetProfile profile;
  profile.kerb_height_m = 0.0;
  profile.kerb_width_m = 0.2;  // the line at the edge
  profile.pavement_end_m = profile.half_road_m + profile.kerb_width_m;
  profile.bumps = 0.25;
  profile.fine_reach_m = 100.0;  // no edge of the ground within the lidar's range
  profile.kerb = Material::kRoadMarking;
  profile.dash_m = 6.0, profile.dash_period_m = 18.0;
  profile.road = Material::kRichAsphalt;
  if (surface == RoadSurface::kWet) profile.road = Material::kWetAsphalt;
  if (surface == RoadSurface::kPoor) {
    profile.road = profile.kerb = Material::kSmoothAsphalt;
    profile.dash_m = 3.0, profile.dash_period_m = 24.0;
  }
  return profile;
}

double ProfileHeight(const StreetProfile& p, double distance_m) {
  if (distance_m < p.half_road_m) return -p.camber * distance_m * distance_m;
  const double kerb = -p.camber * p.half_road_m * p.half_road_m + p.kerb_height_m;
  return kerb + p.pavement_slope * (std::min(distance_m, p.pavement_end_m) - p.half_road_m);
}

Mesh BuildGround(const std::vector<Polyline>& axes, const Terrain& terrain,
                 const StreetProfile& profile) {
  TVL_CHECK(!axes.empty()) << "no streets";
  const DistanceGrid grid(axes, profile.fine_reach_m);
  GroundBuilder builder(profile);
  const auto corner = [&](int x, int y) {
    const Vector2d p = grid.Place(x, y);
    return Corner{Vector3d(p.x(), p.y(), terrain.Height(p)), grid.At(x, y)};
  };
  for (int y = 0; y + 1 < grid.rows(); ++y) {
    for (int x = 0; x + 1 < grid.columns(); ++x) {
      if (std::min(grid.At(x, y), grid.At(x + 1, y + 1)) > profile.fine_reach_m) continue;
      const Corner a = corner(x, y), b = corner(x + 1, y), c = corner(x + 1, y + 1),
                   d = corner(x, y + 1);
      builder.Add({a, b, c});
      builder.Add({a, c, d});
    }
  }
  Mesh mesh = builder.TakeMesh();
  AddSurroundings(grid, terrain, &mesh);
  return mesh;
}

Mesh BuildMarkings(const std::vector<Polyline>& axes, const Terrain& terrain,
                   const StreetProfile& profile) {
  constexpr double kHalfWidth_m = 0.06, kPiece_m = 0.75;
  constexpr double kAbove_m = 0.008;  // paint, above the facets of the road
  Mesh mesh;
  std::vector<Dash> painted;
  // Across the line's own middle, which lies `left` of the axis.
  const auto place = [&](const Polyline& axis, double s, double left, double across) {
    const Vector2d t = axis.Tangent(s), p = axis.At(s) + (left + across) * Vector2d(-t.y(), t.x());
    const double height = ProfileHeight(profile, std::abs(left));
    return Vector3d(p.x(), p.y(), terrain.Height(p) + height + kAbove_m).cast<float>().eval();
  };
  const auto paint = [&](const Polyline& axis, double s, double left) {
    for (double at = s; at < s + profile.dash_m - 1e-9; at += kPiece_m) {
      const double end = at + kPiece_m;
      mesh.AddQuad(place(axis, at, left, -kHalfWidth_m), place(axis, end, left, -kHalfWidth_m),
                   place(axis, end, left, kHalfWidth_m), place(axis, at, left, kHalfWidth_m),
                   Material::kRoadMarking);
    }
  };
  for (size_t line = 0; line < axes.size(); ++line) {
    const Polyline& axis = axes[line];
    for (double s = line == 0 ? 0.0 : 10.0; s < axis.length_m() - profile.dash_m;
         s += profile.dash_period_m) {
      const Dash dash{axis.At(s), static_cast<int>(line), s};
      if (IsPainted(painted, dash)) continue;
      painted.push_back(dash);
      for (const double left : profile.lines_m) paint(axis, s, left);
    }
  }
  return mesh;
}

}  // namespace tvl::sim
