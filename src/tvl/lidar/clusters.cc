#include "tvl/lidar/clusters.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Disjoint sets of points; the smallest index of a set is its root.
class DisjointSets {
 public:
  explicit DisjointSets(size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }

  int32_t Find(int32_t i) {
    while (Parent(i) != i) {
      Parent(i) = Parent(Parent(i));
      i = Parent(i);
    }
    return i;
  }
  void Join(int32_t a, int32_t b) {
    a = Find(a), b = Find(b);
    if (a < b) {
      Parent(b) = a;
    } else {
      Parent(a) = b;
    }
  }

 private:
  int32_t& Parent(int32_t i) { return parent_[static_cast<size_t>(i)]; }
  std::vector<int32_t> parent_;
};

// The angle criterion, without an angle: with p the farther point, cos(beta) = p.(p-q)/(|p||p-q|).
class LinkTest {
 public:
  explicit LinkTest(const ClusterOptions& options)
      : cos_sq_(static_cast<float>(std::pow(std::cos(options.min_angle_rad), 2))),
        noise_m_(static_cast<float>(options.range_noise_m)) {}

  bool operator()(const Eigen::Vector3f& a, float range_a_m, const Eigen::Vector3f& b,
                  float range_b_m) const {
    const bool a_is_far = range_a_m > range_b_m;
    const Eigen::Vector3f& far = a_is_far ? a : b;
    const float range_m = a_is_far ? range_a_m : range_b_m;
    const Eigen::Vector3f d = a_is_far ? Eigen::Vector3f(a - b) : Eigen::Vector3f(b - a);
    const float depth = far.dot(d);  // |p| times the step in depth
    if (depth <= noise_m_ * range_m) return d.squaredNorm() < range_m * range_m;
    return depth * depth < cos_sq_ * range_m * range_m * d.squaredNorm();
  }

 private:
  float cos_sq_, noise_m_;
};

// The test for surfaces seen at a slant: four consecutive points of a ring on a line.
class LineTest {
 public:
  LineTest(const SegmentedScan& scan, const ClusterOptions& options)
      : scan_(scan),
        cos_sq_(static_cast<float>(std::pow(std::cos(options.min_line_angle_rad), 2))),
        tolerance_m_(static_cast<float>(options.line_tolerance_m)),
        share_(static_cast<float>(options.line_tolerance_share)) {}

  // Points a and b = a + 1 of one ring.
  bool operator()(size_t a, float range_m) const {
    const size_t b = a + 1;
    if (a == 0 || b + 1 >= scan_.size()) return false;
    if (scan_.ring[a - 1] != scan_.ring[a] || scan_.ring[b + 1] != scan_.ring[a]) return false;
    const Eigen::Vector3f& pa = scan_.points[a];
    const Eigen::Vector3f& before = scan_.points[a - 1];
    const Eigen::Vector3f chord = scan_.points[b + 1] - before;
    const float length_sq = chord.squaredNorm();
    const float tolerance_m = tolerance_m_ + share_ * range_m;
    if (length_sq > 0.01f * range_m * range_m) return false;  // too far apart to be neighbours
    const Eigen::Vector3f ab = scan_.points[b] - pa;
    const float depth = pa.dot(ab);
    if (depth * depth > cos_sq_ * pa.squaredNorm() * ab.squaredNorm()) return false;
    const float limit = tolerance_m * tolerance_m * length_sq;
    return chord.dot(ab) > 0.0f && chord.cross(pa - before).squaredNorm() < limit &&
           chord.cross(scan_.points[b] - before).squaredNorm() < limit;
  }

 private:
  const SegmentedScan& scan_;
  float cos_sq_, tolerance_m_, share_;
};

DisjointSets LinkNeighbours(const SegmentedScan& scan, const std::vector<uint8_t>& is_ground,
                            const ClusterOptions& options) {
  const RangeImage& image = scan.image;
  const LinkTest linked(options);
  const LineTest on_line(scan, options);
  DisjointSets sets(scan.size());
  const int reach = options.max_bridged_cells + 1;
  // Links cell `from` to the nearest occupied cell in one direction, if that is no ground.
  const auto link = [&](size_t from, int32_t point, size_t to) {
    const int32_t other = image.point[to];
    if (other == RangeImage::kNoPoint) return false;
    const size_t o = static_cast<size_t>(other), p = static_cast<size_t>(point);
    if (is_ground[o]) return true;
    if (linked(scan.points[p], image.range_m[from], scan.points[o], image.range_m[to]) ||
        (o == p + 1 && on_line(p, image.range_m[from]))) {
      sets.Join(point, other);
    }
    return true;
  };
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; ++column) {
      const size_t cell = image.Index(row, column);
      const int32_t point = image.point[cell];
      if (point == RangeImage::kNoPoint || is_ground[static_cast<size_t>(point)]) continue;
      for (int k = 1; k <= reach; ++k) {
        if (link(cell, point, image.Index(row, (column + k) % image.columns))) break;
      }
      for (int k = 1; k <= reach && row + k < image.rows; ++k) {
        if (link(cell, point, image.Index(row + k, column))) break;
      }
    }
  }
  return sets;
}

struct ClusterSize {
  int points = 0, rows = 0, last_row = -1;
};

}  // namespace

void ClusterOptions::Check() const {
  TVL_CHECK_INPUT(min_angle_rad > 0.0 && min_angle_rad < 1.57)
      << "clusters.min_angle_deg: want 0..90, is " << min_angle_rad << " rad";
  TVL_CHECK_INPUT(min_line_angle_rad > 0.0 && min_line_angle_rad < 1.57)
      << "clusters.min_line_angle_deg: want 0..90, is " << min_line_angle_rad << " rad";
  TVL_CHECK_INPUT(line_tolerance_m >= 0.0) << "clusters.line_tolerance_m: must not be negative";
  TVL_CHECK_INPUT(line_tolerance_share >= 0.0)
      << "clusters.line_tolerance_share: must not be negative";
  TVL_CHECK_INPUT(range_noise_m >= 0.0) << "clusters.range_noise_m: must not be negative";
  TVL_CHECK_INPUT(max_bridged_cells >= 0 && max_bridged_cells <= 8)
      << "clusters.max_bridged_cells: want 0..8, is " << max_bridged_cells;
  TVL_CHECK_INPUT(min_points >= 1) << "clusters.min_points: must be positive";
  TVL_CHECK_INPUT(min_rows >= 1) << "clusters.min_rows: must be positive";
  TVL_CHECK_INPUT(min_points_with_rows >= 1) << "clusters.min_points_with_rows: must be positive";
}

ClusterResult FindClusters(const SegmentedScan& scan, const std::vector<uint8_t>& is_ground,
                           const ClusterOptions& options) {
  TVL_CHECK(is_ground.size() == scan.size());
  DisjointSets sets = LinkNeighbours(scan, is_ground, options);
  ClusterResult result;
  result.label.assign(scan.size(), kLabelOutlier);
  std::vector<ClusterSize> size(scan.size());
  for (size_t i = 0; i < scan.size(); ++i) {  // by row: rows of a cluster come in order
    if (is_ground[i]) continue;
    ClusterSize& s = size[static_cast<size_t>(sets.Find(static_cast<int32_t>(i)))];
    ++s.points;
    s.rows += s.last_row != scan.ring[i];
    s.last_row = scan.ring[i];
  }
  for (size_t i = 0; i < scan.size(); ++i) {
    if (is_ground[i]) {
      result.label[i] = kLabelGround;
      continue;
    }
    const size_t root = static_cast<size_t>(sets.Find(static_cast<int32_t>(i)));
    const ClusterSize& s = size[root];
    const bool keep = s.points >= options.min_points ||
                      (s.rows >= options.min_rows && s.points >= options.min_points_with_rows);
    if (!keep) {
      ++result.outliers;
    } else if (root == i) {
      result.label[i] = kFirstClusterLabel + result.clusters++;
    } else {
      result.label[i] = result.label[root];
    }
  }
  return result;
}

}  // namespace tvl
