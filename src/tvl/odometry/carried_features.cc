#include "tvl/odometry/carried_features.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

// Rings further than this from a feature's own see another part of a surface.
constexpr int kMaxRingStep = 3;
// Neighbours of a feature: half a metre near by, and as far apart as the rings on the ground beyond
// (0.5 deg beams at 1.7 m height: 2 m at 20 m).
float NeighbourDistance_m(const Eigen::Vector3f& p) { return 0.5f + 0.08f * p.norm(); }

struct Moments {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
};

Moments Decompose(const RingCloud& cloud, const std::vector<uint32_t>& members) {
  Moments m;
  for (const uint32_t i : members) m.mean += cloud.point(i).cast<double>();
  m.mean /= static_cast<double>(members.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const uint32_t i : members) {
    const Eigen::Vector3d d = cloud.point(i).cast<double>() - m.mean;
    covariance += d * d.transpose();
  }
  m.eigen.computeDirect(Eigen::Matrix3d(covariance / static_cast<double>(members.size())));
  return m;
}

// Members of feature i's own ring and of the nearest ring above and below that has any.
std::vector<uint32_t> Neighbourhood(const RingCloud& cloud, uint32_t i, int own_ring,
                                    int other_ring) {
  std::vector<uint32_t> members;
  const Eigen::Vector3f& p = cloud.point(i);
  const float max_distance_m = NeighbourDistance_m(p);
  cloud.NearestInRing(cloud.ring(i), p, own_ring, max_distance_m, &members);
  for (const int direction : {-1, 1}) {
    const size_t before = members.size();
    for (int step = 1; step <= kMaxRingStep && members.size() == before; ++step) {
      cloud.NearestInRing(cloud.ring(i) + direction * step, p, other_ring, max_distance_m,
                          &members);
    }
  }
  return members;
}

bool SpansRings(const RingCloud& cloud, const std::vector<uint32_t>& members) {
  return std::any_of(members.begin(), members.end(),
                     [&](uint32_t m) { return cloud.ring(m) != cloud.ring(members.front()); });
}

}  // namespace

RingCloud::RingCloud(std::vector<Eigen::Vector3f> points,
                     const std::vector<LaserFeature>& features) {
  TVL_CHECK(points.size() == features.size())
      << points.size() << " points, " << features.size() << " features";
  ring_.reserve(points.size());
  for (uint32_t i = 0; i < points.size(); ++i) {
    const uint16_t ring = features[i].ring;
    ring_.push_back(ring);
    if (by_azimuth_.size() <= ring) by_azimuth_.resize(static_cast<size_t>(ring) + 1);
    by_azimuth_[ring].push_back({std::atan2(points[i].y(), points[i].x()), i});
  }
  for (auto& entries : by_azimuth_) {
    std::sort(entries.begin(), entries.end(), [](const RingEntry& a, const RingEntry& b) {
      return a.azimuth_rad != b.azimuth_rad ? a.azimuth_rad < b.azimuth_rad : a.index < b.index;
    });
  }
  index_ = PointIndex(std::move(points));
}

void RingCloud::NearestInRing(int ring, const Eigen::Vector3f& p, int count, float max_distance_m,
                              std::vector<uint32_t>* out) const {
  if (ring < 0 || ring >= static_cast<int>(by_azimuth_.size())) return;
  const auto& entries = by_azimuth_[static_cast<size_t>(ring)];
  if (entries.empty()) return;
  const float azimuth_rad = std::atan2(p.y(), p.x());
  const int n = static_cast<int>(entries.size());
  const auto first = std::lower_bound(
      entries.begin(), entries.end(), azimuth_rad,
      [](const RingEntry& entry, float azimuth) { return entry.azimuth_rad < azimuth; });
  int up = static_cast<int>(first - entries.begin()), down = up - 1;
  const auto at = [&](int i) -> const RingEntry& {
    return entries[static_cast<size_t>((i % n + n) % n)];
  };
  const auto gap = [&](int i) {
    const double d = std::abs(static_cast<double>(at(i).azimuth_rad) - azimuth_rad);
    return std::min(d, 2.0 * kPi - d);
  };
  const float max_sq = max_distance_m * max_distance_m;
  for (int k = 0; k < std::min(count, n); ++k) {
    const int next = gap(up) <= gap(down) ? up++ : down--;
    const uint32_t index = at(next).index;
    if ((point(index) - p).squaredNorm() <= max_sq) out->push_back(index);
  }
}

LocalFit FitPlaneAround(const RingCloud& cloud, uint32_t i) {
  LocalFit fit;
  const std::vector<uint32_t> members = Neighbourhood(cloud, i, 5, 3);
  if (members.size() < 4 || !SpansRings(cloud, members)) return fit;
  const Moments m = Decompose(cloud, members);
  const Eigen::Vector3d variance = m.eigen.eigenvalues().cwiseMax(0.0);
  fit.axis = m.eigen.eigenvectors().col(0);
  fit.mean = m.mean;
  fit.variance_m2 = variance[0];
  // Flat to 10 cm, and wider than thick: else the normal is noise.
  fit.valid = variance[0] < 0.01 && variance[1] > 4.0 * variance[0] && variance[1] > 0.0025;
  return fit;
}

LocalFit FitLineAround(const RingCloud& cloud, uint32_t i) {
  LocalFit fit;
  const std::vector<uint32_t> members = Neighbourhood(cloud, i, 1, 1);
  if (members.size() < 2 || !SpansRings(cloud, members)) return fit;
  const Moments m = Decompose(cloud, members);
  const Eigen::Vector3d variance = m.eigen.eigenvalues().cwiseMax(0.0);
  fit.axis = m.eigen.eigenvectors().col(2);
  fit.mean = m.mean;
  fit.variance_m2 = variance[1];
  fit.valid = variance[2] > 0.0025 && variance[2] > 9.0 * variance[1];
  return fit;
}

}  // namespace tvl
