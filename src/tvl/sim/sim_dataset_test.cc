#include "tvl/sim/sim_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "tvl/base/check.h"
#include "tvl/geometry/point_index.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/io/kitti_dataset.h"
#include "tvl/io/profile.h"
#include "tvl/io/temp_folder.h"
#include "tvl/io/test_data.h"
#include "tvl/sim/drive_writer.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

SimOptions LidarOnly(const std::string& preset, int frames, uint64_t seed = 5) {
  SimOptions options;
  options.preset = preset, options.frames = frames, options.seed = seed;
  options.has_camera = false;
  return options;
}

// Points of a scan, put right by the vertical correction, in the world.
std::vector<Vector3f> InWorld(const SimDataset& data, size_t index) {
  const SensorFrame frame = data.Frame(index);
  const Eigen::Affine3d T(data.Truth_T_world_lidar(index).Matrix());
  const double raise = data.setup().lidar.vertical_correction_rad;
  std::vector<Vector3f> points;
  for (const Vector3f& stored : frame.scan->points) {
    const Vector3d p = stored.cast<double>();
    const Vector3d axis = p.cross(Vector3d::UnitZ()).normalized();
    points.push_back((T * (Eigen::AngleAxisd(raise, axis) * p)).cast<float>());
  }
  return points;
}

// Distances of every 20th point of `points` to the plane through its neighbours in `map`, where
// these lie in a plane.
std::vector<double> PlaneDistances(const std::vector<Vector3f>& map,
                                   const std::vector<Vector3f>& points) {
  const PointIndex index(map);
  std::vector<double> distances;
  for (size_t i = 0; i < points.size(); i += 20) {
    Neighbour near[12];
    if (index.Nearest(points[i], 12, near) < 12 || near[11].distance_sq_m2 > 0.25F) continue;
    Vector3f mean = Vector3f::Zero();
    for (const Neighbour& n : near) mean += map[n.index] / 12.0F;
    Eigen::Matrix3f scatter = Eigen::Matrix3f::Zero();
    for (const Neighbour& n : near) {
      scatter += (map[n.index] - mean) * (map[n.index] - mean).transpose() / 12.0F;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> eigen(scatter);
    if (eigen.eigenvalues()[0] > 0.02F * eigen.eigenvalues()[1]) continue;
    if (eigen.eigenvalues()[1] < 0.002F) continue;  // a line
    distances.push_back(std::abs(eigen.eigenvectors().col(0).dot(points[i] - mean)));
  }
  return distances;
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(SimDatasetTest, ConsecutiveScansAgreeAtTheTruth) {
  for (const bool clean : {true, false}) {
    SimOptions options = LidarOnly("city", 60);
    options.clean = clean;
    const SimDataset data(options);
    const std::vector<double> distances = PlaneDistances(InWorld(data, 30), InWorld(data, 31));
    ASSERT_GT(distances.size(), 500U);
    EXPECT_LT(Median(distances), clean ? 0.002 : 0.025);
  }
}

TEST(SimDatasetTest, RandomAccessEqualsSequential) {
  SimOptions options = LidarOnly("traffic", 12);
  const SimDataset data(options), again(options);
  std::vector<SensorFrame> frames;
  for (size_t i = 0; i < 5; ++i) frames.push_back(data.Frame(i));
  options.threads = 2;
  const SimDataset threaded(options);
  for (const size_t i : {4U, 0U, 2U}) {
    EXPECT_EQ(again.Frame(i).scan->points, frames[i].scan->points);
    EXPECT_EQ(again.Frame(i).scan->intensity, frames[i].scan->intensity);
    EXPECT_EQ(threaded.Frame(i).scan->points, frames[i].scan->points);
  }
}

TEST(SimDatasetTest, SeedsDiffer) {
  const SimDataset a(LidarOnly("city", 10, 1)), b(LidarOnly("city", 10, 2));
  EXPECT_NE(a.Frame(3).scan->points, b.Frame(3).scan->points);
  EXPECT_NE(a.Truth_T_first_cam0()[9].t(), b.Truth_T_first_cam0()[9].t());
}

TEST(SimDatasetTest, LooksLikeARealScan) {
  const SimDataset data(LidarOnly("city", 200));
  for (const size_t i : {0U, 90U, 199U}) {
    const SensorFrame frame = data.Frame(i);
    EXPECT_GT(frame.scan->size(), 95000U);
    EXPECT_LT(frame.scan->size(), 128000U);
    EXPECT_TRUE(frame.scan->ring.empty()) << "a KITTI file has none";
    EXPECT_TRUE(frame.scan->time_offset_s.empty());
    EXPECT_EQ(frame.stamp, Timestamp::FromSeconds(0.1 * static_cast<double>(i)));
    // The azimuth turns from ring to ring: 64 rings.
    int wraps = 0;
    for (size_t k = 1; k < frame.scan->size(); ++k) {
      const Vector3f &a = frame.scan->points[k - 1], &b = frame.scan->points[k];
      wraps += a.y() < 0 && b.y() >= 0 && a.x() > 0 && b.x() > 0 ? 1 : 0;
    }
    EXPECT_NEAR(wraps, 63, 3);
  }
}

TEST(SimDatasetTest, TruthIsThatOfTheCamera) {
  const SimDataset data(LidarOnly("city", 30));
  const std::vector<Rigid3d> truth = data.Truth_T_first_cam0();
  ASSERT_EQ(truth.size(), 30U);
  EXPECT_THAT(truth[0], Rigid3dNear(Rigid3d(), 0.0, 0.0));
  const Rigid3d T_cam_lidar = data.setup().calibration.T_cam0_lidar;
  const Rigid3d lidar = data.Truth_T_world_lidar(0).Inverse() * data.Truth_T_world_lidar(29);
  EXPECT_THAT(truth[29], Rigid3dNear(T_cam_lidar * lidar * T_cam_lidar.Inverse(), 1e-9, 1e-9));
  EXPECT_GT(truth[29].t().z(), 10.0) << "z is forward";
}

// Places along the lane where something still reaches within 1.5 m: every metre, all around, at
// bumper, window and roof height.
std::vector<double> PlacesTooTight(const SimDataset& data) {
  const SceneView view = data.scene().View(-1e6, -1e6);  // long before anybody moves
  const Drive& drive = data.drive();
  const double length = drive.travel.Way_m(static_cast<double>(data.size()) * kFrameInterval_s);
  std::vector<double> tight;
  for (double way = 0.0; way < length; way += 1.0) {
    const Eigen::Vector2d p = drive.route.lane.At(way);
    const double ground = drive.terrain.Height(p);
    uint32_t blocked = 0;
    RayPacket rays;
    for (int k = 0; k < 72; ++k) {
      const int level = k / 24;
      const double angle = 2 * M_PI * k / 24, up = 0.4 + 0.7 * level;
      rays.Set(k % 8, Vector3d(p.x(), p.y(), ground + up).cast<float>(),
               Vector3d(std::cos(angle), std::sin(angle), 0).cast<float>(), 1.5F);
      if (k % 8 == 7) blocked |= view.Occluded(rays);
    }
    if (blocked != 0) tight.push_back(way);
  }
  return tight;
}

// On all passes.
TEST(SimDatasetTest, NothingStillStandsNearTheLane) {
  for (const char* preset : {"loop", "reverse", "traffic"}) {
    EXPECT_THAT(PlacesTooTight(SimDataset(LidarOnly(preset, 500))), ::testing::IsEmpty()) << preset;
  }
}

TEST(SimDatasetTest, ChangedPlacesAreAnotherSight) {
  SimOptions options = LidarOnly("loop", 700);
  options.clean = true;
  const SimDataset usual(options);
  options.changes = 1.0;
  const SimDataset changed(options);
  EXPECT_EQ(usual.Truth_T_world_lidar(600).t(), changed.Truth_T_world_lidar(600).t());
  EXPECT_NE(usual.Frame(600).scan->points, changed.Frame(600).scan->points);
}

TEST(SimDatasetTest, TunnelHidesTheTown) {
  const SimDataset data(LidarOnly("tunnel", 300));
  const double middle = data.drive().travel.TimeAt(160.0);
  const SensorFrame frame = data.Frame(static_cast<size_t>(10.0 * middle));
  size_t beyond = 0;
  for (const Vector3f& p : frame.scan->points) beyond += std::abs(p.y()) > 4.3F ? 1 : 0;
  EXPECT_LT(beyond, frame.scan->size() / 200);
}

TEST(SimDatasetTest, OpenCountryHasFewFeatures) {
  const SimDataset city(LidarOnly("city", 50)), open(LidarOnly("open", 50));
  const auto high = [](const SimDataset& data) {
    size_t count = 0;
    const SensorFrame frame = data.Frame(25);
    for (const Vector3f& p : frame.scan->points) count += p.z() > -1.2F ? 1 : 0;
    return count;
  };
  EXPECT_LT(high(open), high(city) / 8);
}

// One frame is 100 ms: an image that is late by that is the next one's, but for its noise; the scan
// stays.
TEST(SimDatasetTest, ImagesCanBeLate) {
  const SimDataset usual(ParseSimUri("sim:city?seed=5&frames=12&speed=10"));
  const SimDataset late(ParseSimUri("sim:city?seed=5&frames=12&speed=10&delay=100"));
  const SensorFrame frame = late.Frame(8);
  const auto difference = [&](const cv::Mat& image) {
    return cv::norm(frame.image, image, cv::NORM_L1) / static_cast<double>(image.total());
  };
  EXPECT_LT(difference(usual.Frame(9).image), 0.5 * difference(usual.Frame(8).image));
  EXPECT_EQ(frame.scan->points, usual.Frame(8).scan->points);
}

TEST(SimDatasetTest, WrittenDriveReadsBackTheSame) {
  SimOptions options = LidarOnly("city", 3);
  options.has_camera = true;
  const SimDataset data(options);
  const TempFolder folder;
  size_t last = 0;
  WriteDrive(data, folder.path().string(), 1, [&](size_t done) { last = done; });
  EXPECT_EQ(last, 3U);
  const KittiDataset read(folder.path().string(), data.setup().lidar, {});
  ASSERT_EQ(read.size(), 3U);
  const SensorFrame simulated = data.Frame(2), stored = read.Frame(2);
  EXPECT_EQ(stored.scan->points, simulated.scan->points);
  EXPECT_EQ(stored.scan->intensity, simulated.scan->intensity);
  ASSERT_EQ(stored.image.size(), simulated.image.size());
  EXPECT_TRUE(std::equal(stored.image.begin<uint8_t>(), stored.image.end<uint8_t>(),
                         simulated.image.begin<uint8_t>()));
  EXPECT_EQ(stored.stamp, simulated.stamp);
  EXPECT_THAT(read.setup().calibration.T_cam0_lidar,
              Rigid3dNear(data.setup().calibration.T_cam0_lidar, 1e-7, 1e-9));
  EXPECT_THAT(read.Truth_T_first_cam0()[2], Rigid3dNear(data.Truth_T_first_cam0()[2], 1e-7, 1e-6));
}

TEST(SimDatasetTest, FewerBeamsAreWrittenWithTheirProfile) {
  SimOptions options = LidarOnly("city", 1);
  options.beams = 16;
  const SimDataset data(options);
  const TempFolder folder;
  WriteDrive(data, folder.path().string(), 1, [](size_t) {});
  const LidarModel lidar = LoadProfile(folder / "lidar.yaml");
  EXPECT_THAT(
      lidar.beam_elevation_rad,
      ::testing::Pointwise(::testing::DoubleNear(1e-6), data.setup().lidar.beam_elevation_rad));
  EXPECT_EQ(KittiDataset(folder.path().string(), lidar, {}).Frame(0).scan->size(),
            data.Frame(0).scan->size());
}

TEST(SimDatasetTest, DrivesAlongKittiPoses) {
  const auto path = TestDataPath("trajectories/kitti_06.txt");
  if (!path) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  SimOptions options = LidarOnly("city", 0);
  options.trajectory_file = *path;
  const SimDataset data(options);
  ASSERT_EQ(data.size(), 1101U);
  EXPECT_THAT(PlacesTooTight(data), ::testing::IsEmpty());
  // The end of the drive leads along its beginning: the street is the same, heights included.
  size_t back = 0;
  double nearest = 1e9;
  for (size_t i = 800; i < data.size(); ++i) {
    const double distance =
        (data.Truth_T_world_lidar(i).t() - data.Truth_T_world_lidar(60).t()).norm();
    if (distance < nearest) nearest = distance, back = i;
  }
  EXPECT_LT(nearest, 2.0);
  EXPECT_LT(Median(PlaneDistances(InWorld(data, 60), InWorld(data, back))), 0.03);
}

}  // namespace
}  // namespace tvl::sim
