// A patch of the local map: the statistics of the points that fell into one voxel.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace tvl {

// Sums of integer coordinates (1/1024 m, relative to the voxel's centre): exact, so that the order
// of adding does not matter and removing undoes adding to the last bit.
struct PointMoments {
  int64_t count = 0;
  int64_t sum[3] = {0, 0, 0};
  int64_t square[6] = {0, 0, 0, 0, 0, 0};  // xx xy xz yy yz zz

  // `sign` is +1 to add, -1 to take away.
  void Add(const Eigen::Vector3d& p_centred_m, int sign);
  Eigen::Vector3d MeanCentred_m() const;  // count > 0
  Eigen::Matrix3d Covariance_m2() const;  // of the points (not of their mean); count > 0
};

enum class SurfelKind : uint8_t { kNone, kPlane, kLine };

// Eigenvalues ascending: thickness, width, length squared.
struct Surfel {
  SurfelKind kind = SurfelKind::kNone;
  Eigen::Vector3d mean;    // p_world, m
  Eigen::Vector3d axis;    // plane: unit normal; line: unit direction
  double thickness_sq_m2;  // variance across the plane (line: across the line, larger of the two)
  double extent_sq_m2;     // plane: smaller variance along it; line: variance along it
  double count;
};

struct SurfelOptions {
  int min_points = 8;              // fewer say nothing of a normal
  double max_thickness_m = 0.15;   // standard deviation across; relief and noise stay below
  double min_shape_ratio = 2.0;    // width / thickness (plane), length / width (line), std. dev.
  double min_extent_share = 0.12;  // of the voxel's edge: one arc of a single ring is no plane
  void Check() const;
};

Surfel FitPlane(const PointMoments& moments, const Eigen::Vector3d& centre_m, double size_m,
                const SurfelOptions& options);
Surfel FitLine(const PointMoments& moments, const Eigen::Vector3d& centre_m, double size_m,
               const SurfelOptions& options);

}  // namespace tvl
