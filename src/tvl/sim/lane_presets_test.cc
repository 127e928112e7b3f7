#include "tvl/sim/lane_presets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tvl/base/units.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/sim/sim_dataset.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

SimOptions LidarOnly(const std::string& preset, uint64_t seed, int frames = 300) {
  SimOptions options;
  options.preset = preset, options.seed = seed, options.frames = frames;
  options.has_camera = false;
  return options;
}

// Share of what is met within 80 m by a cone of rays that lies on movers.
struct Share {
  size_t met = 0, on_movers = 0;
  double value() const { return static_cast<double>(on_movers) / static_cast<double>(met); }
};

class Looker {
 public:
  Looker(const SimDataset& data, size_t frame)
      : T_(data.Truth_T_world_lidar(frame)),
        view_(ViewAt(data, static_cast<double>(frame) * kFrameInterval_s)) {}

  void Look(const Vector3f& direction_lidar, Share* share) const {
    RayPacket rays;
    rays.Set(0, T_.t().cast<float>(), (T_.R().cast<float>() * direction_lidar).normalized(), 80.0F);
    const SceneHit hit = view_.Intersect(rays)[0];
    share->met += hit.hit ? 1 : 0;
    share->on_movers += hit.hit && hit.is_mover ? 1 : 0;
  }

 private:
  static SceneView ViewAt(const SimDataset& data, double time_s) {
    return data.scene().View(time_s, time_s);
  }

  Rigid3d T_;
  SceneView view_;
};

// Of the returns of an HDL-64E, at every fourth beam and every degree.
double LidarShare(const SimDataset& data, size_t frame) {
  const Looker looker(data, frame);
  Share share;
  const auto& beams = data.setup().lidar.beam_elevation_rad;
  for (size_t beam = 0; beam < beams.size(); beam += 4) {
    for (int degree = 0; degree < 360; ++degree) {
      const double azimuth = DegToRad(degree);
      const Eigen::Vector3d direction(std::cos(azimuth), std::sin(azimuth), std::tan(beams[beam]));
      looker.Look(direction.cast<float>(), &share);
    }
  }
  return share.value();
}

// Of the columns of the image, those that show movers at eye level: the horizon's row and 20 px
// below it.
double ImageShare(const SimDataset& data, size_t frame) {
  const Looker looker(data, frame);
  const Camera& camera = data.setup().calibration.camera;
  Share share;
  for (int x = 4; x < camera.width_px; x += 8) {
    Share column;
    for (const double below : {0.0, 20.0}) {
      const double across = (x - camera.cx_px) / camera.fx_px;
      looker.Look(
          Vector3f(1.0F, static_cast<float>(-across), static_cast<float>(-below / camera.fy_px)),
          &column);
    }
    share.met += 1;
    share.on_movers += column.on_movers == 2 ? 1 : 0;
  }
  return share.value();
}

class JamTest : public ::testing::TestWithParam<uint64_t> {};

TEST_P(JamTest, LorriesFillTheViewAtTimes) {
  const SimDataset data(LidarOnly("jam", GetParam()));
  double lidar = 0.0, image = 0.0, least = 1.0;
  for (size_t frame = 0; frame < data.size(); frame += 15) {
    lidar = std::max(lidar, LidarShare(data, frame));
    least = std::min(least, LidarShare(data, frame));
    image = std::max(image, ImageShare(data, frame));
  }
  EXPECT_GE(lidar, 0.6);
  EXPECT_GE(image, 0.6);
  EXPECT_LT(lidar, 0.95) << "the town must be seen, too";
  EXPECT_GT(least, 0.1);
}

TEST_P(JamTest, EgoAndOthersStandAndMoveAtDifferentTimes) {
  const SimDataset data(LidarOnly("jam", GetParam()));
  const TravelProfile& ego = data.drive().travel;
  const JamFlows flows = PlanJam(GetParam(), 30.0);
  int ego_stands = 0, others_stand = 0, together = 0, length = 0;
  double fastest = 0.0;
  for (double t = 0.0; t < 30.0; t += 0.1) {
    const double speed = ego.Speed_m_s(t);
    const std::array<double, 3> others = {flows.faster.Speed_m_s(t), flows.slower.Speed_m_s(t),
                                          flows.equal.Speed_m_s(t)};
    const double quickest = *std::max_element(others.begin(), others.end());
    const double slowest = *std::min_element(others.begin(), others.end());
    fastest = std::max(fastest, speed);
    ego_stands += speed < 0.02 && quickest > 0.5 ? 1 : 0;
    others_stand += speed > 0.5 && slowest < 0.02 ? 1 : 0;
    together += speed > 0.5 && std::abs(flows.equal.Speed_m_s(t) - speed) < 0.1 ? 1 : 0;
    ++length;
  }
  EXPECT_LT(fastest, 3.01);
  EXPECT_GT(data.Length_m(), 10.0);
  EXPECT_GT(ego_stands, 10) << "of " << length;
  EXPECT_GT(others_stand, 10);
  EXPECT_GT(together, 10);
  EXPECT_GT(flows.faster.Way_m(30.0), flows.slower.Way_m(30.0) + 5.0);
}

TEST_P(JamTest, NobodyRunsIntoAnybody) {
  const SimOptions options = LidarOnly("jam", GetParam());
  const Drive drive = PlanDrive(options, Rigid3d());
  const Prototypes prototypes = BuildPrototypes(options.seed);
  const LaneTraffic traffic = JamTraffic(LanePoses(drive.route, drive.terrain, drive.profile),
                                         drive.travel, prototypes, 30.0, options.seed);
  for (double t = 0.0; t < 30.0; t += 1.0) {
    std::vector<std::array<double, 3>> spans;  // lane, begin and end of each vehicle
    const double ego = drive.travel.Way_m(t);
    spans.push_back({0.0, ego - 2.3, ego + 2.3});
    for (const LaneVehicle& v : traffic.vehicles()) {
      const double way = traffic.Way_m(v, t), half = 0.5 * prototypes.LengthOf_m(v.prototype);
      spans.push_back({std::round(v.left_m / kLaneWidth_m), way - half, way + half});
    }
    std::sort(spans.begin(), spans.end());
    for (size_t i = 1; i < spans.size(); ++i) {
      if (spans[i][0] != spans[i - 1][0]) continue;
      EXPECT_GT(spans[i][1], spans[i - 1][2] + 1.0) << t;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, JamTest, ::testing::Values(1, 2, 3));

TEST(PassingTest, EgoStandsWhileTwoLorriesPassAtOnce) {
  for (const int beams : {16, 32, 64}) {
    SimOptions options = LidarOnly("passing", 1, 200);
    options.beams = beams;
    const SimDataset data(options);
    for (const Rigid3d& T : data.Truth_T_first_cam0()) {
      EXPECT_THAT(T, Rigid3dNear(Rigid3d(), 1e-9, 1e-9));
    }
    EXPECT_EQ(data.Frame(100).scan->ring.empty(), beams == 64);
    EXPECT_LT(LidarShare(data, 0), 0.02);
    EXPECT_GT(LidarShare(data, 100), 0.3) << beams;
  }
}

TEST(PassingTest, LorriesDriveAt5MetresASecond) {
  const SimOptions options = LidarOnly("passing", 1);
  const Drive drive = PlanDrive(options, Rigid3d());
  const LaneTraffic traffic = PassingTraffic(LanePoses(drive.route, drive.terrain, drive.profile),
                                             drive.travel, BuildPrototypes(1), 30.0);
  const std::vector<SceneMover> before = traffic.Movers(14.9, 15.0),
                                after = traffic.Movers(15.0, 15.1);
  ASSERT_EQ(before.size(), 2U);
  for (size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d a = before[i].T_world_object_begin.t(),
                          b = after[i].T_world_object_end.t();
    EXPECT_NEAR((b - a).norm() / 0.2, 5.0, 0.1);
    const Eigen::Vector3d p =
        drive.T_world_lidar.At(15.0).Inverse() * after[i].T_world_object_begin.t();
    EXPECT_NEAR(p.x(), 0.0, 0.1);
    EXPECT_NEAR(std::abs(p.y()), kLaneWidth_m, 0.1);
  }
}

}  // namespace
}  // namespace tvl::sim
