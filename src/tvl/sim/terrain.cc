#include "tvl/sim/terrain.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr uint64_t kTerrainStream = 101;

// Quadratic B-spline weights of the cells left of, at and right of the offset x in [0, 1).
std::array<double, 3> Weights(double x) {
  return {0.5 * (1 - x) * (1 - x), 0.5 + x * (1 - x), 0.5 * x * x};
}

struct Cells {
  int columns, rows;
  std::vector<double> sum, weight;
  size_t At(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(columns) + static_cast<size_t>(x);
  }
};

// Fills cells without samples from their neighbours, coarse to fine in rounds.
void FillEmpty(Cells* cells, std::vector<double>* heights) {
  double mean = 0.0, count = 0.0;
  for (size_t i = 0; i < cells->sum.size(); ++i) mean += cells->sum[i], count += cells->weight[i];
  mean /= std::max(count, 1e-9);
  // Solve a screened Laplace equation by sweeps: known cells pull hard, unknown ones follow.
  for (size_t i = 0; i < heights->size(); ++i) {
    (*heights)[i] = cells->weight[i] > 1e-6 ? cells->sum[i] / cells->weight[i] : mean;
  }
  for (int sweep = 0; sweep < 120; ++sweep) {
    for (int y = 1; y + 1 < cells->rows; ++y) {
      for (int x = 1; x + 1 < cells->columns; ++x) {
        const size_t i = cells->At(x, y);
        if (cells->weight[i] > 1e-3) continue;
        (*heights)[i] = 0.25 * ((*heights)[cells->At(x - 1, y)] + (*heights)[cells->At(x + 1, y)] +
                                (*heights)[cells->At(x, y - 1)] + (*heights)[cells->At(x, y + 1)]);
      }
    }
  }
}

// Spreads the samples over the cells around them, Gaussian with sigma of a cell and a half.
void Splat(const std::vector<Vector3d>& samples, const Vector2d& origin, double cell_m,
           Cells* cells) {
  constexpr int kReach = 4;
  for (const Vector3d& s : samples) {
    const double fx = (s.x() - origin.x()) / cell_m, fy = (s.y() - origin.y()) / cell_m;
    const int cx = static_cast<int>(fx), cy = static_cast<int>(fy);
    for (int y = std::max(0, cy - kReach); y <= std::min(cells->rows - 1, cy + kReach); ++y) {
      for (int x = std::max(0, cx - kReach); x <= std::min(cells->columns - 1, cx + kReach); ++x) {
        const double dx = x + 0.5 - fx, dy = y + 0.5 - fy;
        const double weight = std::exp(-0.5 * (dx * dx + dy * dy) / 2.25);
        cells->sum[cells->At(x, y)] += weight * s.z();
        cells->weight[cells->At(x, y)] += weight;
      }
    }
  }
}

}  // namespace

Terrain Terrain::Rolling(uint64_t seed, double steepness) {
  Rng rng(seed, kTerrainStream);
  Terrain terrain;
  for (int i = 0; i < 5; ++i) {
    const double direction = rng.Uniform(0.0, 2.0 * kPi), wavelength = rng.Uniform(150.0, 350.0);
    const double k = 2.0 * kPi / wavelength;
    // Slope amplitude 0.4-1.0 % each.
    terrain.waves_.push_back({k * Vector2d(std::cos(direction), std::sin(direction)),
                              steepness * rng.Uniform(0.004, 0.010) / k,
                              rng.Uniform(0.0, 2.0 * kPi)});
  }
  return terrain;
}

Terrain Terrain::Through(const std::vector<Vector3d>& samples) {
  TVL_CHECK(!samples.empty()) << "no heights";
  constexpr double kMargin_m = 120.0;
  Terrain terrain;
  terrain.cell_m_ = 6.0;
  Vector2d low = samples[0].head<2>(), high = low;
  for (const Vector3d& s : samples) {
    low = low.cwiseMin(s.head<2>()), high = high.cwiseMax(s.head<2>());
  }
  terrain.origin_ = low.array() - kMargin_m;
  terrain.columns_ = static_cast<int>((high.x() - low.x() + 2 * kMargin_m) / terrain.cell_m_) + 3;
  terrain.rows_ = static_cast<int>((high.y() - low.y() + 2 * kMargin_m) / terrain.cell_m_) + 3;
  Cells cells{terrain.columns_, terrain.rows_, {}, {}};
  const size_t n = static_cast<size_t>(cells.columns) * static_cast<size_t>(cells.rows);
  cells.sum.assign(n, 0.0), cells.weight.assign(n, 0.0);
  Splat(samples, terrain.origin_, terrain.cell_m_, &cells);
  terrain.grid_m_.assign(n, 0.0);
  FillEmpty(&cells, &terrain.grid_m_);
  return terrain;
}

double Terrain::Height(const Vector2d& p) const {
  double z = 0.0;
  for (const Wave& w : waves_) z += w.amplitude_m * std::sin(w.k_rad_m.dot(p) + w.phase_rad);
  if (grid_m_.empty()) return z;
  const double fx = std::clamp((p.x() - origin_.x()) / cell_m_, 1.0, columns_ - 2.001);
  const double fy = std::clamp((p.y() - origin_.y()) / cell_m_, 1.0, rows_ - 2.001);
  const int cx = static_cast<int>(fx), cy = static_cast<int>(fy);
  const auto wx = Weights(fx - cx), wy = Weights(fy - cy);
  for (int y = 0; y < 3; ++y) {
    const double* row = &grid_m_[static_cast<size_t>(cy + y - 1) * static_cast<size_t>(columns_)];
    for (int x = 0; x < 3; ++x) {
      z += wx[static_cast<size_t>(x)] * wy[static_cast<size_t>(y)] * row[cx + x - 1];
    }
  }
  return z;
}

Vector3d Terrain::Normal(const Vector2d& p) const {
  constexpr double kStep_m = 0.5;
  const double dx = Height(p + Vector2d(kStep_m, 0)) - Height(p - Vector2d(kStep_m, 0));
  const double dy = Height(p + Vector2d(0, kStep_m)) - Height(p - Vector2d(0, kStep_m));
  return Vector3d(-dx, -dy, 2.0 * kStep_m).normalized();
}

std::vector<double> ConsistentHeights(const std::vector<Vector3d>& samples, double near_m) {
  // Least squares for a correction c: neighbours change alike (stiff), revisits agree (z + c).
  const auto n = static_cast<int>(samples.size());
  constexpr double kStiffness = 400.0;  // against 1 for each agreeing pair
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(n);
  const auto link = [&](int i, int j, double weight, double target) {
    entries.emplace_back(i, i, weight), entries.emplace_back(j, j, weight);
    entries.emplace_back(i, j, -weight), entries.emplace_back(j, i, -weight);
    rhs[i] -= weight * target, rhs[j] += weight * target;
  };
  std::vector<double> s(samples.size(), 0.0);
  for (size_t i = 1; i < samples.size(); ++i) {
    s[i] = s[i - 1] + (samples[i] - samples[i - 1]).head<2>().norm();
    link(static_cast<int>(i) - 1, static_cast<int>(i), kStiffness, 0.0);
  }
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, i, 1e-6);
    for (int j = i + 1; j < n; ++j) {
      const auto a = static_cast<size_t>(i), b = static_cast<size_t>(j);
      if (s[b] - s[a] < 50.0) continue;
      if ((samples[b] - samples[a]).head<2>().squaredNorm() > near_m * near_m) continue;
      link(i, j, 1.0, samples[a].z() - samples[b].z());
    }
  }
  Eigen::SparseMatrix<double> A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  const Eigen::VectorXd c = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(A).solve(rhs);
  std::vector<double> heights;
  for (int i = 0; i < n; ++i) heights.push_back(samples[static_cast<size_t>(i)].z() + c[i]);
  return heights;
}

}  // namespace tvl::sim
