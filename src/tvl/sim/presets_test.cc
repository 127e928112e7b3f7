// Drives that begin at speed, the highway, and the tunnel with a fast start.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/base/units.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/sim/sim_dataset.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

SimOptions LidarOnly(const std::string& uri) {
  SimOptions options = ParseSimUri(uri);
  options.has_camera = false;
  return options;
}

Rigid3d At(const Drive& drive, int frame) {
  return drive.T_world_lidar.At(frame * kFrameInterval_s);
}

struct Start {
  double speed_m_s, across_m_s2;
};

// Over the first frames.
Start StartOf(const Drive& drive) {
  const Vector3d a = At(drive, 0).t(), b = At(drive, 1).t(), c = At(drive, 2).t();
  const Vector3d left = At(drive, 1).q() * Vector3d::UnitY();
  return {(c - a).norm() / 0.2, std::abs((c - 2.0 * b + a).dot(left)) / 0.01};
}

class SpeedTest : public ::testing::TestWithParam<double> {};

TEST_P(SpeedTest, DriveBeginsInMotion) {
  for (const bool is_turning : {false, true}) {
    SimOptions options = LidarOnly("sim:city?frames=60&seed=4");
    options.speed_m_s = GetParam();
    options.is_turning = is_turning;
    const Drive drive = PlanDrive(options, Rigid3d());
    const Start start = StartOf(drive);
    EXPECT_NEAR(start.speed_m_s, GetParam(), 0.03 * GetParam());
    const double last = (At(drive, 59).t() - At(drive, 58).t()).norm() / 0.1;
    EXPECT_NEAR(last, GetParam(), 0.03 * GetParam());
    EXPECT_LE(start.across_m_s2, 3.0);
    EXPECT_EQ(start.across_m_s2 > 0.9, is_turning) << start.across_m_s2;
    const Rigid3d turned = At(drive, 0).Inverse() * At(drive, 20);
    EXPECT_EQ(turned.RotationAngle() > DegToRad(5.0), is_turning);
  }
}

INSTANTIATE_TEST_SUITE_P(All, SpeedTest, ::testing::Values(5.0, 15.0, 30.0));

TEST(PresetStartTest, UsualPresetsBeginRolling) {
  for (const char* preset : {"city", "loop", "traffic", "tunnel", "open"}) {
    const Start start = StartOf(PlanDrive(LidarOnly(std::string("sim:") + preset), Rigid3d()));
    EXPECT_GT(start.speed_m_s, 5.0) << preset;
  }
}

TEST(BeamsTest, ScansComeWithRingsOfTheRightElevation) {
  for (const int beams : {16, 32}) {
    const std::string uri = "sim:city?frames=2&clean=1&raw=cw&beams=" + std::to_string(beams);
    const SimDataset data(LidarOnly(uri));
    const LidarModel& model = data.setup().lidar;
    EXPECT_EQ(model.rows(), beams);
    EXPECT_NO_THROW(model.Check());
    const SensorFrame frame = data.Frame(0);
    ASSERT_EQ(frame.scan->ring.size(), frame.scan->size());
    ASSERT_EQ(frame.scan->time_offset_s.size(), frame.scan->size());
    double lowest = 1.0, highest = -1.0;
    for (size_t i = 0; i < frame.scan->size(); i += 97) {
      const double elevation = std::asin(frame.scan->points[i].normalized().z());
      EXPECT_NEAR(elevation, model.beam_elevation_rad[frame.scan->ring[i]], 1e-4);
      lowest = std::min(lowest, elevation), highest = std::max(highest, elevation);
    }
    EXPECT_NEAR(RadToDeg(highest), 15.0, 0.01);
    EXPECT_NEAR(RadToDeg(lowest), beams == 16 ? -15.0 : -25.0, 0.01);
  }
}

// Returns from what stands beside the road, and from the road by distance.
struct Returns {
  size_t beside = 0, near_road = 0, far_road = 0;
};

Returns CountReturns(const SimDataset& data, int frame) {
  Returns count;
  for (const Vector3f& p : data.Frame(static_cast<size_t>(frame)).scan->points) {
    const float distance = p.head<2>().norm();
    if (p.z() > -0.7F && std::abs(p.y()) > 8.0F) ++count.beside;
    if (std::abs(p.y()) > 4.0F || p.z() > -0.7F) continue;
    if (distance < 10.0F) ++count.near_road;
    if (distance > 25.0F) ++count.far_road;
  }
  return count;
}

TEST(HighwayTest, NothingStandsBesideItForAKilometre) {
  for (const char* speed : {"25", "35"}) {
    const SimDataset data(LidarOnly("sim:highway?seed=2&speed=" + std::string(speed)));
    const TravelProfile& travel = data.drive().travel;
    EXPECT_NEAR(data.Length_m(), kHighway_m, 0.03 * kHighway_m) << "all of it is driven";
    const auto frame_at = [&](double way_m) {
      return static_cast<int>(10.0 * travel.TimeAt(data.drive().route.start_m + way_m));
    };
    const size_t before = CountReturns(data, frame_at(40.0)).beside;
    const size_t after = CountReturns(data, frame_at(1440.0)).beside;
    EXPECT_GT(before, 5000U);
    EXPECT_GT(after, 5000U);
    for (double way = 290.0; way < 1270.0; way += 98.0) {
      EXPECT_LT(CountReturns(data, frame_at(way)).beside, before / 100) << way;
    }
  }
}

TEST(HighwayTest, BendsAreGentleAndTheSpeedIsHeld) {
  const Drive drive = PlanDrive(LidarOnly("sim:highway?speed=35&seed=2"), Rigid3d());
  for (int k = 1; k + 1 < drive.frames; ++k) {
    const Vector3d a = At(drive, k - 1).t(), b = At(drive, k).t(), c = At(drive, k + 1).t();
    EXPECT_NEAR((c - a).norm() / 0.2, 35.0, 1.0) << k;
    EXPECT_LT((c - 2.0 * b + a).head<2>().norm() / 0.01, 2.0) << k;
  }
}

TEST(HighwayTest, WetRoadLosesItsFarReturns) {
  const SimDataset rich(LidarOnly("sim:highway?seed=2")),
      wet(LidarOnly("sim:highway?seed=2&road=wet"));
  const Returns dry = CountReturns(rich, 250), rain = CountReturns(wet, 250);
  EXPECT_GT(dry.far_road, 200U);
  EXPECT_LT(rain.far_road, dry.far_road / 6);
  EXPECT_GT(rain.near_road, dry.near_road / 3);
}

// Mean and spread of the grey values of the road ahead of the car.
struct Tone {
  double mean, spread;
};

Tone RoadTone(const std::string& road) {
  const SimDataset data(ParseSimUri("sim:highway?seed=2&frames=600&road=" + road));
  const cv::Mat image = data.Frame(250).image;
  const cv::Mat patch = image(cv::Rect(500, 270, 150, 90));
  double sum = 0.0, sum_sq = 0.0;
  for (int y = 0; y < patch.rows; ++y) {
    for (int x = 0; x < patch.cols; ++x) {
      const double value = patch.at<uint8_t>(y, x);
      sum += value, sum_sq += value * value;
    }
  }
  const double n = patch.rows * patch.cols;
  return {sum / n, std::sqrt(std::max(0.0, sum_sq / n - sum * sum / (n * n)))};
}

TEST(HighwayTest, RoadsDifferInWhatIsToBeSeen) {
  const Tone rich = RoadTone("rich"), poor = RoadTone("poor"), wet = RoadTone("wet");
  EXPECT_GT(rich.spread, 1.5 * poor.spread);
  EXPECT_LT(wet.mean, 0.8 * poor.mean);
  EXPECT_LT(wet.spread, rich.spread / 1.5);
}

TEST(TunnelTest, LeavesItsStopFaster) {
  const Drive usual = PlanDrive(LidarOnly("sim:tunnel?seed=3&frames=400"), Rigid3d());
  const Drive fast = PlanDrive(LidarOnly("sim:tunnel?seed=3&frames=400&faster=0.4"), Rigid3d());
  const auto speed = [](const Drive& drive, double way_m) {
    return drive.travel.Speed_m_s(drive.travel.TimeAt(way_m));
  };
  const double stop = usual.route.stops_m[0], end = usual.route.tunnel_end_m;
  for (double way = 70.0; way < stop - 5.0; way += 10.0) {
    EXPECT_NEAR(speed(fast, way), speed(usual, way), 0.1) << "before the stop";
  }
  for (double way = stop + 10.0; way < end; way += 10.0) {
    EXPECT_GT(speed(fast, way), 1.1 * speed(usual, way)) << "gathering speed";
  }
  EXPECT_NEAR(speed(fast, end), 1.4 * speed(usual, end), 0.1 * speed(usual, end));
}

TEST(FaultyDriveTest, UriMakesFaults) {
  const auto good = OpenSimulation("sim:city?frames=12&camera=0");
  const auto faulty = OpenSimulation("sim:city?frames=12&camera=0&faults=drop:3-4;renumber");
  ASSERT_EQ(faulty->size(), 10U);
  const SensorFrame frame = faulty->Frame(3);
  EXPECT_EQ(frame.scan->points, good->Frame(5).scan->points);
  EXPECT_EQ(frame.stamp, Timestamp::FromSeconds(0.3));
  EXPECT_EQ(faulty->Truth_T_first_cam0()[3].t(), good->Truth_T_first_cam0()[5].t());
}

}  // namespace
}  // namespace tvl::sim
