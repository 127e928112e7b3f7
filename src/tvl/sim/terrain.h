// The height of the ground.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace tvl::sim {

// A smooth height over the plane. Const and thread-safe.
class Terrain {
 public:
  Terrain() = default;  // flat, at height 0
  // Gently rolling: waves of 150-350 m with slopes of up to about 3 % (times `steepness`).
  static Terrain Rolling(uint64_t seed, double steepness = 1.0);
  // Through measured heights (x, y, z) along a drive; places visited twice get one height. Beyond
  // the drive the height levels out.
  static Terrain Through(const std::vector<Eigen::Vector3d>& samples);

  double Height(const Eigen::Vector2d& p) const;
  // Unit normal.
  Eigen::Vector3d Normal(const Eigen::Vector2d& p) const;

 private:
  struct Wave {
    Eigen::Vector2d k_rad_m = Eigen::Vector2d::Zero();  // direction and 2 pi / wavelength
    double amplitude_m = 0.0, phase_rad = 0.0;
  };
  std::vector<Wave> waves_;
  // Control heights of a uniform quadratic B-spline; empty: waves only.
  std::vector<double> grid_m_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  int columns_ = 0, rows_ = 0;
};

// Heights of a drive whose measurement drifts: changes them smoothly so that places visited more
// than once (within `near_m`, more than 50 m of path apart) get the same height, keeping the
// slopes as measured. `samples` are (x, y, z) in the order of the drive.
std::vector<double> ConsistentHeights(const std::vector<Eigen::Vector3d>& samples, double near_m);

}  // namespace tvl::sim
