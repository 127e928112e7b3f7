#include "tvl/depth/depth_association.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

Camera TestCamera() {
  Camera camera;
  camera.fx_px = camera.fy_px = 700.0;
  camera.cx_px = 600.0;
  camera.cy_px = 180.0;
  return camera;
}

Rigid3d CamFromLidar() {
  Eigen::Matrix3d R;
  R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {R, Eigen::Vector3d(0.0, -0.08, -0.27)};
}

LidarModel Hdl64() {
  LidarModel model;
  for (int i = 0; i < 32; ++i) model.beam_elevation_rad.push_back(DegToRad(2.0 - i / 3.0));
  for (int i = 0; i < 32; ++i) model.beam_elevation_rad.push_back(DegToRad(-8.8333 - i / 2.0));
  return model;
}

// A surface: range along a unit beam (infinite: missed) and its label.
struct Surface {
  std::function<double(const Eigen::Vector3d&)> range_m;
  int32_t label;
};

// n^T p = d in the lidar frame, where the predicate holds.
Surface Plane(const Eigen::Vector3d& n, double d, int32_t label,
              std::function<bool(const Eigen::Vector3d&)> holds = {}) {
  return {[=](const Eigen::Vector3d& beam) {
            const double range_m = d / n.dot(beam);
            if (!(range_m > 0.0) || (holds && !holds(range_m * beam))) return kInf;
            return range_m;
          },
          label};
}

Surface Ground() { return Plane({0, 0, 1}, -1.73, kLabelGround); }

// Every beam of the front quarter, the nearest surface, 2 cm noise.
SegmentedScan Scan(const std::vector<Surface>& surfaces, double sigma_m = 0.02) {
  const LidarModel model = Hdl64();
  SegmentedScan scan;
  Rng rng(31);
  for (int row = 0; row < model.rows(); ++row) {
    const double elevation = model.beam_elevation_rad[static_cast<size_t>(row)];
    for (int column = -256; column <= 256; ++column) {
      const double azimuth = -2.0 * kPi * column / 2048.0;
      const Eigen::Vector3d beam(std::cos(elevation) * std::cos(azimuth),
                                 std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double nearest_m = 120.0;
      int32_t label = -1;
      for (const Surface& s : surfaces) {
        const double range_m = s.range_m(beam);
        if (range_m < nearest_m) {
          nearest_m = range_m;
          label = s.label;
        }
      }
      if (label < 0) continue;
      scan.points.push_back(((nearest_m + sigma_m * rng.Normal()) * beam).cast<float>());
      scan.ring.push_back(static_cast<uint16_t>(row));
      scan.label.push_back(label);
    }
  }
  return scan;
}

// Tracks looking at points of the lidar frame.
FeatureTracks LookAt(const std::vector<Eigen::Vector3d>& p_lidar) {
  FeatureTracks tracks;
  for (const Eigen::Vector3d& p : p_lidar) {
    FeatureTrack track;
    track.ray_cam = (CamFromLidar() * p).hnormalized();
    track.px_cam = track.px_cam_prev = TestCamera().Project(track.ray_cam);
    tracks.tracks.push_back(track);
  }
  return tracks;
}

VisualDepths Depths(const std::vector<Eigen::Vector3d>& p_lidar, const SegmentedScan& scan,
                    const DepthOptions& options = {}) {
  return AssociateDepth(LookAt(p_lidar), scan.points, scan, TestCamera(), CamFromLidar(), Hdl64(),
                        options);
}

double TrueDepth_m(const Eigen::Vector3d& p_lidar) { return (CamFromLidar() * p_lidar).z(); }

TEST(DepthAssociation, WallInFront) {
  const SegmentedScan scan = Scan({Ground(), Plane({1, 0, 0}, 15.0, 2)});
  const std::vector<Eigen::Vector3d> points = {
      {15, 0, 0}, {15, 3.1, -0.4}, {15, -6.2, -1.1}, {15, 5.3, 0.2}};
  const VisualDepths depths = Depths(points, scan);
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(depths[i].status, DepthStatus::kOk) << i;
    EXPECT_NEAR(depths[i].depth_m, TrueDepth_m(points[i]), 0.03);
    EXPECT_GT(depths[i].sigma_m, 0.01);
    EXPECT_LT(depths[i].sigma_m, 0.06);
  }
}

// The lower block's rings lie 0.5 deg apart: the rectangle must hold two everywhere.
TEST(DepthAssociation, GroundOutTo25Metres) {
  const SegmentedScan scan = Scan({Ground()});
  std::vector<Eigen::Vector3d> points;
  for (double x = 6.0; x < 25.0; x += 0.37) points.emplace_back(x, 0.1 * x, -1.73);
  const VisualDepths depths = Depths(points, scan);
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(depths[i].status, DepthStatus::kOk) << points[i].x() << " m";
    EXPECT_NEAR(depths[i].depth_m, TrueDepth_m(points[i]), 4.0 * depths[i].sigma_m);
    EXPECT_NEAR(depths[i].depth_m, TrueDepth_m(points[i]), 0.15);
  }
  // Uncertain along the ray: a corner 0.7 px off means a lot at grazing incidence.
  EXPECT_GT(depths.back().sigma_m, 0.2);
  EXPECT_LT(depths.front().sigma_m, 0.1);
}

TEST(DepthAssociation, ThePapersTenDegreesDropFarGround) {
  const SegmentedScan scan = Scan({Ground()});
  DepthOptions paper;
  paper.min_incidence_rad = DegToRad(10.0);
  const VisualDepths depths = Depths({{8, 0, -1.73}, {12, 0, -1.73}}, scan, paper);
  EXPECT_EQ(depths[0].status, DepthStatus::kOk);
  EXPECT_EQ(depths[1].status, DepthStatus::kGrazing);
}

// Paper Fig. 6: a sign before a wall.
TEST(DepthAssociation, ForegroundWinsByLabel) {
  const auto on_sign = [](const Eigen::Vector3d& p) { return p.y() > 0.0 && p.y() < 1.0; };
  const SegmentedScan scan = Scan({Plane({1, 0, 0}, 20.0, 2), Plane({1, 0, 0}, 8.0, 3, on_sign)});
  const VisualDepths depths = Depths({{8, 0.03, -0.3}, {8, 0.97, -0.5}, {20, 3.5, 0}}, scan);
  EXPECT_NEAR(depths[0].depth_m, 8.0 - 0.27, 0.05);
  EXPECT_NEAR(depths[1].depth_m, 8.0 - 0.27, 0.05);
  EXPECT_NEAR(depths[2].depth_m, 20.0 - 0.27, 0.05);
}

// The same scene in one label: the depths spread and no plane fits.
TEST(DepthAssociation, MixedSurfacesAreRejected) {
  const auto on_sign = [](const Eigen::Vector3d& p) { return p.y() > 0.0 && p.y() < 1.0; };
  const SegmentedScan scan = Scan({Plane({1, 0, 0}, 20.0, 2), Plane({1, 0, 0}, 8.0, 2, on_sign)});
  EXPECT_EQ(Depths({{8, 0.03, -0.3}}, scan)[0].status, DepthStatus::kSpread);
}

TEST(DepthAssociation, EveryWayToHaveNoDepth) {
  const auto narrow = [](const Eigen::Vector3d& p) { return std::abs(p.z() + 0.5) < 0.05; };
  SegmentedScan scan = Scan({Plane({1, 0, 0}, 12.0, 2, narrow)});
  EXPECT_EQ(Depths({{12, 0, 4}}, scan)[0].status, DepthStatus::kNoPoints);
  EXPECT_EQ(Depths({{12, 0, -0.5}}, scan)[0].status, DepthStatus::kOneRing);
  const auto slim = [](const Eigen::Vector3d& p) { return std::abs(p.y()) < 0.01; };
  scan = Scan({Plane({1, 0, 0}, 8.0, 2, slim)});
  EXPECT_EQ(Depths({{8, 0, -0.5}}, scan)[0].status, DepthStatus::kSmallTriangle);
  scan = Scan({Plane({1, 0, 0}, 55.0, 2)});
  EXPECT_EQ(Depths({{55, 0, 0}}, scan)[0].status, DepthStatus::kTooFar);
  scan = Scan({Ground()});
  EXPECT_EQ(Depths({{32, 0, -1.73}}, scan)[0].status, DepthStatus::kGrazing);
}

// Features just above the line where the ground ends: its plane would put them behind that line.
TEST(DepthAssociation, ThePlaneDoesNotReachBeyondItsPoints) {
  const double end_m = 22.9;
  const auto near = [=](const Eigen::Vector3d& p) { return p.x() < end_m; };
  const SegmentedScan scan = Scan({Plane({0, 0, 1}, -1.73, kLabelGround, near)});
  std::vector<Eigen::Vector3d> beyond;
  for (double x = 23.0; x < 26.0; x += 0.05) beyond.emplace_back(x, 0.0, -1.73);
  int rejected = 0;
  for (const VisualDepth& depth : Depths(beyond, scan)) {
    rejected += depth.status == DepthStatus::kSpread;
    if (depth.status == DepthStatus::kOk) {
      EXPECT_LT(depth.depth_m, 1.04 * end_m);
    }
  }
  EXPECT_GT(rejected, 5);
}

TEST(DepthAssociation, SigmaGrowsWithThePixelsError) {
  const SegmentedScan scan = Scan({Ground()});
  const Eigen::Vector3d p(15.0, 0.0, -1.73);
  DepthOptions exact;
  exact.sigma_px = 0.0;
  const VisualDepth with = Depths({p}, scan)[0], without = Depths({p}, scan, exact)[0];
  const double tan_a = 1.65 / TrueDepth_m(p);  // the camera is 1.65 m above the ground
  const double expected_m = with.depth_m * DepthOptions().sigma_px / (700.0 * tan_a);
  EXPECT_NEAR(std::sqrt(std::pow(with.sigma_m, 2) - std::pow(without.sigma_m, 2)), expected_m,
              0.05 * expected_m);
  EXPECT_GT(without.sigma_m, 0.02 / tan_a);  // the range's noise remains
}

TEST(DepthAssociation, OutliersAreLeftOutUnlessAskedFor) {
  const SegmentedScan scan = Scan({Plane({1, 0, 0}, 10.0, kLabelOutlier)});
  EXPECT_EQ(Depths({{10, 0, 0}}, scan)[0].status, DepthStatus::kNoPoints);
  DepthOptions options;
  options.use_outlier_points = true;
  EXPECT_EQ(Depths({{10, 0, 0}}, scan, options)[0].status, DepthStatus::kOk);
}

TEST(DepthAssociation, LeastSquaresBeatsThreePoints) {
  const SegmentedScan scan = Scan({Plane({1, 0, 0}, 15.0, 2)}, 0.05);
  std::vector<Eigen::Vector3d> points;
  for (double y = -5.0; y < 5.0; y += 0.13) points.emplace_back(15.0, y, -0.4 + 0.03 * y);
  const auto rms_m = [&](const DepthOptions& options) {
    double sum = 0.0;
    const VisualDepths depths = Depths(points, scan, options);
    for (size_t i = 0; i < points.size(); ++i) {
      sum += std::pow(depths[i].depth_m - TrueDepth_m(points[i]), 2);
    }
    return std::sqrt(sum / static_cast<double>(points.size()));
  };
  DepthOptions three;
  three.least_squares_points = 1000000;
  EXPECT_LT(rms_m({}), 0.6 * rms_m(three));
}

TEST(DepthAssociation, BrokenContractsThrow) {
  const SegmentedScan scan = Scan({Ground()});
  EXPECT_THROW(
      AssociateDepth(LookAt({{9, 0, -1.73}}), {}, scan, TestCamera(), CamFromLidar(), Hdl64()),
      Error);
  EXPECT_TRUE(AssociateDepth({}, scan.points, scan, TestCamera(), CamFromLidar(), Hdl64()).empty());
  DepthOptions options;
  options.half_width_rad = 0.0;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
