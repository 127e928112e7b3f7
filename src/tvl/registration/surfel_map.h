// Voxel grids of surfels at one or several sizes: the surrounding map at constant cost.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/geometry/voxel_hash.h"
#include "tvl/registration/surfel.h"

namespace tvl {

struct SurfelMapOptions {
  SurfelKind kind = SurfelKind::kPlane;
  // Edges of the voxels, finest first; the finest level that has a surfel answers.
  std::vector<double> sizes_m = {0.5, 1.0, 2.0};
  SurfelOptions surfel;
  void Check() const;
};

// Exactly invertible: Remove of what was Added leaves the map as if it had never been there.
// Lookups are safe from several threads while nobody writes.
class SurfelMap {
 public:
  explicit SurfelMap(const SurfelMapOptions& options);

  // Adds or takes away points, moved by T_world_lidar. The same arguments undo each other.
  void Add(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_world_lidar,
           const Executor& executor);
  void Remove(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_world_lidar,
              const Executor& executor);

  // The surfel nearest to p_world among the eight voxels around it, at the finest level that has
  // one; null where there is none.
  const Surfel* Find(const Eigen::Vector3d& p_world) const;

  // Points in the column of the coarsest voxels through p_world, from one voxel above it to `below`
  // of them underneath: where there are many, something standing there would have been seen.
  int64_t PointsInColumn(const Eigen::Vector3d& p_world, int below) const;
  // Centres of the finest voxels that hold points.
  std::vector<Eigen::Vector3f> OccupiedPlaces() const;
  // Centres of the coarsest voxels that hold points, and their edge.
  std::vector<Eigen::Vector3d> KnownPlaces() const;
  double coarsest_m() const { return levels_.back().size_m; }

  size_t voxels() const;  // with at least one point, all levels

 private:
  struct Cell {
    Surfel surfel;  // first: lookups read its head, next to the key
    PointMoments moments;
    bool dirty = false;          // touched by the change in progress
    bool counted_empty = false;  // in Level::empty
  };
  struct Level {
    double size_m = 1.0;
    VoxelHash<Cell> cells;
    size_t empty = 0;  // cells without points, left behind by Remove
  };
  void Change(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_world_lidar, int sign,
              const Executor& executor);
  void ChangeLevel(const std::vector<Eigen::Vector3d>& p_world, int sign, Level* level) const;
  void Refresh(const VoxelKey& key, Level* level) const;
  void DropEmpty(Level* level) const;
  Surfel Fit(const Cell& cell, const VoxelKey& key, double size_m) const;

  SurfelMapOptions options_;
  std::vector<Level> levels_;
};

}  // namespace tvl
