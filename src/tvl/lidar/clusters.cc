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
  explicit DisjointSets(size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
  }

  void Join(size_t a, size_t b) {
    if (parent_[a] == parent_[b]) return;
    a = Find(a), b = Find(b);
    if (a < b) {
      parent_[b] = a;
    } else {
      parent_[a] = b;
    }
  }

  // The root of every point.
  std::vector<size_t> Roots() && {
    // A parent comes before its children: its own root is known by then.
    for (size_t& parent : parent_) parent = parent_[parent];
    return std::move(parent_);
  }

 private:
  size_t Find(size_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }
  std::vector<size_t> parent_;
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

// Walks over the image and joins what belongs together.
class Linker {
 public:
  Linker(const SegmentedScan& scan, const std::vector<uint8_t>& is_ground,
         const ClusterOptions& options)
      : scan_(scan),
        is_ground_(is_ground),
        linked_(options),
        on_line_(scan, options),
        reach_(static_cast<size_t>(options.max_bridged_cells) + 1),
        sets_(scan.size()) {}

  // The root of every point's component; ground points are their own.
  std::vector<size_t> Link() {
    const RangeImage& image = scan_.image;
    const size_t rows = static_cast<size_t>(image.rows);
    const size_t columns = static_cast<size_t>(image.columns);
    for (size_t row = 0; row < rows; ++row) {
      const size_t row_begin = row * columns, down = std::min(reach_, rows - 1 - row);
      for (size_t column = 0; column < columns; ++column) {
        const size_t cell = row_begin + column;
        const int32_t point = image.point[cell];
        if (point == RangeImage::kNoPoint || is_ground_[static_cast<size_t>(point)]) continue;
        for (size_t k = 1; k <= reach_; ++k) {
          const size_t right = column + k < columns ? cell + k : cell + k - columns;
          if (TryLink(cell, right)) break;
        }
        for (size_t k = 1; k <= down; ++k) {
          if (TryLink(cell, cell + k * columns)) break;
        }
      }
    }
    return std::move(sets_).Roots();
  }

 private:
  // Joins two cells if they belong together and neither is ground; false if `to` is empty.
  bool TryLink(size_t from, size_t to) {
    const RangeImage& image = scan_.image;
    if (image.point[to] == RangeImage::kNoPoint) return false;
    const size_t p = static_cast<size_t>(image.point[from]);
    const size_t q = static_cast<size_t>(image.point[to]);
    if (is_ground_[q]) return true;
    if (linked_(scan_.points[p], image.range_m[from], scan_.points[q], image.range_m[to]) ||
        (q == p + 1 && on_line_(p, image.range_m[from]))) {
      sets_.Join(p, q);
    }
    return true;
  }

  const SegmentedScan& scan_;
  const std::vector<uint8_t>& is_ground_;
  const LinkTest linked_;
  const LineTest on_line_;
  const size_t reach_;
  DisjointSets sets_;
};

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
  const std::vector<size_t> root_of = Linker(scan, is_ground, options).Link();
  ClusterResult result;
  result.label.assign(scan.size(), kLabelOutlier);
  std::vector<ClusterSize> size(scan.size());
  for (size_t i = 0; i < scan.size(); ++i) {  // by row: rows of a cluster come in order
    if (is_ground[i]) continue;
    ClusterSize& s = size[root_of[i]];
    ++s.points;
    s.rows += s.last_row != scan.ring[i];
    s.last_row = scan.ring[i];
  }
  for (size_t i = 0; i < scan.size(); ++i) {
    if (is_ground[i]) {
      result.label[i] = kLabelGround;
      continue;
    }
    const size_t root = root_of[i];
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
