#include "tvl/lidar/clusters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <queue>
#include <set>

#include "tvl/lidar/range_image.h"
#include "tvl/lidar/test_scene.h"

namespace tvl {
namespace {

using test::Box;
using test::Plane;
using test::Surface;

struct Labelled {
  SegmentedScan scan;  // intensity is the surface
  ClusterResult result;
  // Labels met on a surface, with their counts.
  std::map<int32_t, int> LabelsOn(int surface) const {
    std::map<int32_t, int> labels;
    for (size_t i = 0; i < scan.size(); ++i) {
      if (static_cast<int>(scan.intensity[i]) == surface) ++labels[result.label[i]];
    }
    return labels;
  }
  int MainLabel(int surface) const {
    const auto labels = LabelsOn(surface);
    return std::max_element(labels.begin(), labels.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }
};

Labelled Label(const std::vector<Surface>& world, double noise_m = 0.02,
               const ClusterOptions& options = {}) {
  const LidarModel model = test::Hdl64();
  test::SimulatedScan sim = test::Scan(world, model, noise_m);
  for (size_t i = 0; i < sim.surface.size(); ++i) {
    sim.scan.intensity[i] = static_cast<float>(sim.surface[i]);
  }
  RingAssignment rings;
  rings.row = sim.ring;
  rings.rows = model.rows();
  Labelled out;
  out.scan =
      BuildRangeImage(sim.scan, ComputeScanGeometry(sim.scan), rings, model, Deskew::kNone).scan;
  out.result = FindClusters(out.scan, std::vector<uint8_t>(out.scan.size(), 0), options);
  return out;
}

TEST(Clusters, ObjectsOneBehindTheOtherAreSeparate) {
  const Labelled l = Label({Box({8, -1, -1}, {9, 1, 0.1}), Box({11, -4, -2}, {12, 4, 0.3})});
  EXPECT_NE(l.MainLabel(0), l.MainLabel(1));
  EXPECT_GE(l.MainLabel(0), kFirstClusterLabel);
  EXPECT_GE(l.LabelsOn(0)[l.MainLabel(0)], 0.98 * 300);
  EXPECT_EQ(l.LabelsOn(0).count(l.MainLabel(1)), 0u);
}

TEST(Clusters, NoisyWallIsOneClusterUpTo40m) {
  for (const double distance_m : {4.0, 10.0, 20.0, 40.0}) {
    const Labelled l = Label({Box({distance_m, -8, -3}, {distance_m + 1, 8, 3})});
    const auto labels = l.LabelsOn(0);
    EXPECT_GT(labels.at(l.MainLabel(0)), 0.97 * static_cast<double>(l.scan.size()))
        << distance_m << " m, " << labels.size() << " labels";
  }
}

TEST(Clusters, WallsAlongTheStreetStayWhole) {
  // Seen at 6 to 90 deg; beyond 8 m the angle criterion alone would cut it into columns.
  const Labelled l = Label({Plane({0, 1, 0}, 5.0, [](const Eigen::Vector3d& p) {
    return p.x() > 0.0 && p.x() < 30.0 && p.z() < 2.0;
  })});
  const auto labels = l.LabelsOn(0);
  EXPECT_GT(labels.at(l.MainLabel(0)), 0.9 * static_cast<double>(l.scan.size()));
}

TEST(Clusters, ColumnsWrapAround) {
  const Labelled l = Label({Box({-11, -2, -1}, {-10, 2, 1})});
  EXPECT_EQ(l.result.clusters, 1);
}

TEST(Clusters, SmallOnesAreOutliers) {
  // 20 m away: a pole over many rows is kept, a stick lying across two is not.
  const Labelled l =
      Label({Box({20, 3, -1}, {20.2, 3.2, 1.5}), Box({20, -3, -0.5}, {20.2, 0, -0.45})}, 0.0);
  EXPECT_GE(l.MainLabel(0), kFirstClusterLabel);
  const auto stick = l.LabelsOn(1);
  ASSERT_FALSE(stick.empty());
  ASSERT_LT(stick.begin()->second, 50);
  EXPECT_EQ(l.MainLabel(1), kLabelOutlier);
  EXPECT_EQ(l.result.outliers, stick.at(kLabelOutlier));
}

TEST(Clusters, OneEmptyCellIsBridgedTwoAreNot) {
  SegmentedScan scan;
  scan.image.rows = 1;
  scan.image.columns = 64;
  scan.image.range_m.assign(64, 0.0f);
  scan.image.point.assign(64, RangeImage::kNoPoint);
  // Cells 5-7, 9-11 (one empty between), 14-16 (two empty).
  for (const int column : {5, 6, 7, 9, 10, 11, 14, 15, 16}) {
    const double azimuth = kPi - (column + 0.5) * 2.0 * kPi / 64;
    scan.image.point[static_cast<size_t>(column)] = static_cast<int32_t>(scan.points.size());
    scan.image.range_m[static_cast<size_t>(column)] = 5.0f;
    scan.points.emplace_back(5.0 * std::cos(azimuth), 5.0 * std::sin(azimuth), 0.0);
    scan.ring.push_back(0);
  }
  ClusterOptions options;
  options.min_points = 2;
  const ClusterResult r = FindClusters(scan, std::vector<uint8_t>(9, 0), options);
  EXPECT_EQ(r.label, (std::vector<int32_t>{2, 2, 2, 2, 2, 2, 3, 3, 3}));
}

// The same clusters by a plain breadth-first search over an explicit neighbour test.
std::vector<int> BreadthFirst(const SegmentedScan& scan, const ClusterOptions& options) {
  const RangeImage& image = scan.image;
  std::vector<int> component(scan.size(), -1);
  const auto linked = [&](size_t a, size_t b) {
    const double da = scan.points[a].norm(), db = scan.points[b].norm();
    const double far = std::max(da, db), near = std::min(da, db);
    const double cos_alpha =
        scan.points[a].cast<double>().dot(scan.points[b].cast<double>()) / (da * db);
    const double sin_alpha = std::sqrt(1.0 - cos_alpha * cos_alpha);
    const double beta = std::atan2(near * sin_alpha, far - near * cos_alpha);
    return beta > options.min_angle_rad || far - near * cos_alpha < options.range_noise_m;
  };
  int components = 0;
  std::vector<std::pair<int, int>> cell(scan.size());
  for (int r = 0; r < image.rows; ++r) {
    for (int c = 0; c < image.columns; ++c) {
      const int32_t p = image.point[image.Index(r, c)];
      if (p >= 0) cell[static_cast<size_t>(p)] = {r, c};
    }
  }
  for (size_t start = 0; start < scan.size(); ++start) {
    if (component[start] >= 0) continue;
    std::queue<size_t> queue({start});
    component[start] = components++;
    while (!queue.empty()) {
      const size_t p = queue.front();
      queue.pop();
      for (const auto& [dr, dc] : {std::pair{0, 1}, {0, -1}, {1, 0}, {-1, 0}}) {
        for (int k = 1; k <= 2; ++k) {
          const int r = cell[p].first + k * dr;
          const int c = (cell[p].second + k * dc + image.columns) % image.columns;
          if (r < 0 || r >= image.rows) break;
          const int32_t q = image.point[image.Index(r, c)];
          if (q < 0) continue;
          if (component[static_cast<size_t>(q)] < 0 && linked(p, static_cast<size_t>(q))) {
            component[static_cast<size_t>(q)] = component[start];
            queue.push(static_cast<size_t>(q));
          }
          break;
        }
      }
    }
  }
  return component;
}

TEST(Clusters, SameAsBreadthFirstSearch) {
  ClusterOptions options;
  options.min_line_angle_rad = 1.56;  // the angle criterion alone
  options.line_tolerance_m = options.line_tolerance_share = 0.0;
  options.min_points = 1;  // every component a cluster
  const Labelled l = Label({Plane({0, 0, 1}, -1.7), Box({5, -3, -2}, {6, 3, 1}),
                            Plane({0.3, 1, 0}, 9.0), Plane({-0.2, 1, 0.1}, -7.0)},
                           0.05, options);
  const std::vector<int> expected = BreadthFirst(l.scan, options);
  // The two partitions match, but for the odd link that float and double decide differently.
  std::map<int, std::map<int32_t, int>> labels_of;
  for (size_t i = 0; i < expected.size(); ++i) ++labels_of[expected[i]][l.result.label[i]];
  int different = 0;
  std::set<int32_t> used;
  for (const auto& [component, labels] : labels_of) {
    int most = 0, all = 0;
    int32_t main = 0;
    for (const auto& [label, count] : labels) {
      all += count;
      if (count > most) most = count, main = label;
    }
    different += used.insert(main).second ? all - most : all;
  }
  EXPECT_LT(different, 0.001 * static_cast<double>(expected.size()));
  EXPECT_GT(l.result.clusters, 100);
}

}  // namespace
}  // namespace tvl
