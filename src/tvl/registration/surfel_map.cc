#include "tvl/registration/surfel_map.h"

#include <cmath>
#include <limits>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// The nearest surfel of the 2 x 2 x 2 voxels whose corner is nearest to p.
template <typename Cell>
const Surfel* FindAtLevel(const VoxelHash<Cell>& cells, double size_m, const Eigen::Vector3d& p) {
  const VoxelKey low = VoxelKey::Of(p - Eigen::Vector3d::Constant(0.5 * size_m), size_m);
  const Surfel* best = nullptr;
  double best_sq = size_m * size_m;
  for (int i = 0; i < 8; ++i) {
    const Cell* cell = cells.Find({low.x + (i & 1), low.y + ((i >> 1) & 1), low.z + (i >> 2)});
    if (cell == nullptr || cell->surfel.kind == SurfelKind::kNone) continue;
    const double distance_sq = (cell->surfel.mean - p).squaredNorm();
    if (distance_sq < best_sq) {
      best_sq = distance_sq;
      best = &cell->surfel;
    }
  }
  return best;
}

}  // namespace

void SurfelMapOptions::Check() const {
  TVL_CHECK_INPUT(!sizes_m.empty()) << "surfel_map.sizes_m: at least one size";
  for (const double size_m : sizes_m) {
    TVL_CHECK_INPUT(size_m > 0.05) << "surfel_map.sizes_m: must exceed 0.05, is " << size_m;
  }
  surfel.Check();
}

SurfelMap::SurfelMap(const SurfelMapOptions& options) : options_(options) {
  options_.Check();
  for (const double size_m : options_.sizes_m) {
    Level level;
    level.size_m = size_m;
    levels_.push_back(level);
  }
}

void SurfelMap::Add(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_world_lidar,
                    const Executor& executor) {
  Change(points, T_world_lidar, 1, executor);
}

void SurfelMap::Remove(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_world_lidar,
                       const Executor& executor) {
  Change(points, T_world_lidar, -1, executor);
}

void SurfelMap::Change(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T_world_lidar,
                       int sign, const Executor& executor) {
  const Eigen::Matrix3d R = T_world_lidar.R();
  std::vector<Eigen::Vector3d> p_world(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    p_world[i] = R * points[i].cast<double>() + T_world_lidar.t();
  }
  executor.For(levels_.size(), 1,
               [&](size_t begin, size_t) { ChangeLevel(p_world, sign, &levels_[begin]); });
}

void SurfelMap::ChangeLevel(const std::vector<Eigen::Vector3d>& p_world, int sign,
                            Level* level) const {
  std::vector<VoxelKey> touched;
  for (const Eigen::Vector3d& p : p_world) {
    const VoxelKey key = VoxelKey::Of(p, level->size_m);
    Cell& cell = level->cells[key];
    if (!cell.dirty) {
      cell.dirty = true;
      touched.push_back(key);
    }
    cell.moments.Add(p - key.Centre(level->size_m), sign);
  }
  for (const VoxelKey& key : touched) Refresh(key, level);
  if (2 * level->empty > level->cells.size()) DropEmpty(level);
}

void SurfelMap::Refresh(const VoxelKey& key, Level* level) const {
  Cell& cell = *level->cells.Find(key);
  const bool is_empty = cell.moments.count == 0;
  cell.dirty = false;
  cell.surfel = is_empty ? Surfel() : Fit(cell, key, level->size_m);
  if (is_empty && !cell.counted_empty) ++level->empty;
  if (!is_empty && cell.counted_empty) --level->empty;
  cell.counted_empty = is_empty;
}

void SurfelMap::DropEmpty(Level* level) const {
  VoxelHash<Cell> kept;
  for (const auto& entry : level->cells.entries()) {
    if (entry.value.moments.count > 0) kept[entry.key] = entry.value;
  }
  level->cells = std::move(kept);
  level->empty = 0;
}

Surfel SurfelMap::Fit(const Cell& cell, const VoxelKey& key, double size_m) const {
  const Eigen::Vector3d centre_m = key.Centre(size_m);
  return options_.kind == SurfelKind::kLine
             ? FitLine(cell.moments, centre_m, size_m, options_.surfel)
             : FitPlane(cell.moments, centre_m, size_m, options_.surfel);
}

const Surfel* SurfelMap::Find(const Eigen::Vector3d& p_world) const {
  for (const Level& level : levels_) {
    const Surfel* found = FindAtLevel(level.cells, level.size_m, p_world);
    if (found != nullptr) return found;
  }
  return nullptr;
}

int64_t SurfelMap::PointsInColumn(const Eigen::Vector3d& p_world, int below) const {
  const Level& coarsest = levels_.back();
  const VoxelKey key = VoxelKey::Of(p_world, coarsest.size_m);
  int64_t points = 0;
  for (int dz = 1; dz >= -below; --dz) {
    const Cell* cell = coarsest.cells.Find({key.x, key.y, key.z + dz});
    if (cell != nullptr) points += cell->moments.count;
  }
  return points;
}

std::vector<Eigen::Vector3f> SurfelMap::OccupiedPlaces() const {
  const Level& finest = levels_.front();
  std::vector<Eigen::Vector3f> places;
  for (const auto& entry : finest.cells.entries()) {
    if (entry.value.moments.count == 0) continue;
    places.push_back(entry.key.Centre(finest.size_m).cast<float>());
  }
  return places;
}

std::vector<Eigen::Vector3d> SurfelMap::KnownPlaces() const {
  const Level& coarsest = levels_.back();
  std::vector<Eigen::Vector3d> places;
  for (const auto& entry : coarsest.cells.entries()) {
    if (entry.value.moments.count > 0) places.push_back(entry.key.Centre(coarsest.size_m));
  }
  return places;
}

size_t SurfelMap::voxels() const {
  size_t count = 0;
  for (const Level& level : levels_) count += level.cells.size() - level.empty;
  return count;
}

}  // namespace tvl
