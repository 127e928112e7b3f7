#include "tvl/sim/lidar_sensor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

LidarModel Model() {
  LidarModel model;
  for (int i = 0; i < 8; ++i) model.beam_elevation_rad.push_back(DegToRad(2.0 - i));
  model.sweep_s = 0.1;
  return model;
}

// A closed room around the origin: |x|, |y| <= 10, |z| <= 4.
SceneDescription Room(Material material) {
  SceneDescription d;
  d.structures.resize(1);
  d.structures[0].mesh.AddBox({-10, -10, -4}, {10, 10, 4}, material);
  return d;
}

LidarSweep Standing() {
  LidarSweep sweep;
  sweep.T_world_lidar = [](double) { return Rigid3d(); };
  return sweep;
}

float DistanceToRoom(const Vector3f& p) {
  return std::min({std::abs(std::abs(p.x()) - 10.0F), std::abs(std::abs(p.y()) - 10.0F),
                   std::abs(std::abs(p.z()) - 4.0F)});
}

LidarScan Take(const LidarSensorOptions& options, const LidarSweep& sweep,
               const LidarModel& model = Model()) {
  const Scene scene(Room(Material::kPlaster));
  const LidarSensor sensor(model, options);
  return sensor.Scan(scene.View(-0.05, 0.05), sweep, Executor(1));
}

LidarSensorOptions Clean() {
  LidarSensorOptions options;
  options.has_errors = false;
  return options;
}

TEST(LidarSensorTest, CleanScanIsExactAndInStoredOrder) {
  const LidarScan scan = Take(Clean(), Standing());
  ASSERT_EQ(scan.size(), 8U * 2083U);
  for (size_t i = 0; i < scan.size(); ++i) {
    EXPECT_LT(DistanceToRoom(scan.points[i]), 1e-4F);
    EXPECT_EQ(scan.ring[i], i / 2083);
    const double elevation = std::asin(scan.points[i].normalized().z());
    EXPECT_NEAR(elevation, Model().beam_elevation_rad[scan.ring[i]], 1e-5);
  }
  // Straight ahead first, then to the left, as in KITTI's files.
  EXPECT_NEAR(std::atan2(scan.points[0].y(), scan.points[0].x()), 0.0, 0.002);
  EXPECT_GT(scan.points[100].y(), 0.0F);
  EXPECT_GT(scan.points[2083].x(), 9.0F);
}

TEST(LidarSensorTest, ErrorsAreThoseAskedFor) {
  LidarSensorOptions options;
  options.beam_range_sigma_m = 0.0, options.beam_elevation_sigma_rad = 0.0;
  options.angle_sigma_rad = 0.0;
  const LidarScan scan = Take(options, Standing());
  double sum_sq = 0.0;
  int count = 0;
  for (const Vector3f& p : scan.points) {
    // Straight at the walls, where the distance to the wall is the error of the range.
    if (std::min(std::abs(p.x()), std::abs(p.y())) > 1.0F) continue;
    sum_sq += DistanceToRoom(p) * DistanceToRoom(p);
    ++count;
  }
  ASSERT_GT(count, 500);
  EXPECT_NEAR(std::sqrt(sum_sq / count), 0.02, 0.002);
  EXPECT_LT(scan.size(), 8U * 2083U) << "some pulses are lost";
  for (const float intensity : scan.intensity) {
    EXPECT_NEAR(intensity * 100.0F, std::round(intensity * 100.0F), 1e-3);
  }
}

// Mean error of the ranges of each row, from what lies straight ahead and behind, on flat walls.
std::vector<double> RangeErrorsOfRows(const LidarSensorOptions& options, int rows) {
  LidarModel model;
  for (int i = 0; i < rows; ++i)
    model.beam_elevation_rad.push_back(DegToRad(10.0 - 20.0 * i / rows));
  model.sweep_s = 0.1;
  const LidarScan scan = Take(options, Standing(), model);
  std::vector<double> sum(static_cast<size_t>(rows)), count(static_cast<size_t>(rows));
  for (size_t i = 0; i < scan.size(); ++i) {
    const Vector3f& p = scan.points[i];
    if (std::abs(p.y()) > 1.0F) continue;  // where the wall is hit head-on
    const double true_range = 10.0 * p.norm() / std::abs(p.x());
    sum[scan.ring[i]] += p.norm() - true_range;
    count[scan.ring[i]] += 1.0;
  }
  for (size_t row = 0; row < sum.size(); ++row) sum[row] /= count[row];
  return sum;
}

double Rms(const std::vector<double>& values) {
  double sum_sq = 0.0;
  for (const double value : values) sum_sq += value * value;
  return std::sqrt(sum_sq / static_cast<double>(values.size()));
}

TEST(LidarSensorTest, BeamErrorsHaveTheShapeAskedFor) {
  constexpr int kRows = 32;
  LidarSensorOptions options;
  options.range_sigma_m = 0.0, options.beam_elevation_sigma_rad = 0.0;
  const std::vector<double> independent = RangeErrorsOfRows(options, kRows);
  options.beam_error_shape = BeamErrorShape::kSine;
  const std::vector<double> sine = RangeErrorsOfRows(options, kRows);
  EXPECT_NEAR(Rms(independent), 0.03, 0.01) << "of 32 numbers";
  EXPECT_NEAR(Rms(sine), 0.03, 1e-3);
  const double mean = std::accumulate(sine.begin(), sine.end(), 0.0) / kRows;
  EXPECT_NEAR(mean, 0.0, 1e-3);
  // Neighbours of a sine of one period differ by at most 2 pi / rows of its amplitude.
  double largest_sine = 0.0, largest_independent = 0.0;
  for (size_t row = 1; row < sine.size(); ++row) {
    largest_sine = std::max(largest_sine, std::abs(sine[row] - sine[row - 1]));
    largest_independent =
        std::max(largest_independent, std::abs(independent[row] - independent[row - 1]));
  }
  EXPECT_LT(largest_sine, 0.03 * std::sqrt(2.0) * 2.0 * kPi / kRows + 1e-3);
  EXPECT_GT(largest_independent, 0.03);
}

TEST(LidarSensorTest, StoredPointsLieTooLow) {
  LidarModel model = Model();
  model.vertical_correction_rad = DegToRad(0.205);
  LidarSensorOptions options = Clean();
  const LidarScan low = Take(options, Standing(), model);
  // The ranges are those of the higher beams: put right, the points are back on the walls.
  double worst_stored = 0.0, worst_right = 0.0;
  for (size_t i = 0; i < low.size(); ++i) {
    const Vector3f p = low.points[i];
    const float range = p.norm(), level = p.head<2>().norm();
    const float elevation = std::asin(p.z() / range) + static_cast<float>(DegToRad(0.205));
    const Vector3f right(p.x() / level * range * std::cos(elevation),
                         p.y() / level * range * std::cos(elevation), range * std::sin(elevation));
    worst_stored = std::max(worst_stored, static_cast<double>(DistanceToRoom(p)));
    worst_right = std::max(worst_right, static_cast<double>(DistanceToRoom(right)));
  }
  EXPECT_LT(worst_right, 1e-3);
  EXPECT_GT(worst_stored, 3e-3);
}

class SpinTest : public ::testing::TestWithParam<bool> {};

// Driving at 10 m/s, turning: raw points are those of their own instants, and compensating them
// puts them on the walls.
TEST_P(SpinTest, RawAndCompensatedPointsAgree) {
  LidarSweep sweep;
  sweep.T_world_lidar = [](double t) {
    Vector6d xi;
    xi << 0, 0, 0.5, 10, 0, 0;
    return Rigid3d::Exp(t * xi);
  };
  sweep.is_clockwise = GetParam();
  LidarScan compensated = Take(Clean(), sweep);
  sweep.is_compensated = false;
  const LidarScan raw = Take(Clean(), sweep);
  ASSERT_EQ(raw.size(), compensated.size());
  double moved = 0.0;
  for (size_t i = 0; i < raw.size(); ++i) {
    EXPECT_LT(DistanceToRoom(compensated.points[i]), 1e-3F);
    const Eigen::Vector3d p =
        sweep.T_world_lidar(raw.time_offset_s[i]) * raw.points[i].cast<double>();
    EXPECT_LT((p - compensated.points[i].cast<double>()).norm(), 1e-3);
    moved = std::max(moved, (p - raw.points[i].cast<double>()).norm());
    // The left side is measured first by a clockwise scanner: it starts behind.
    const double azimuth = std::atan2(raw.points[i].y(), raw.points[i].x());
    if (std::abs(azimuth) < 0.1) {
      EXPECT_LT(std::abs(raw.time_offset_s[i]), 0.002);
    }
    if (azimuth > 1.0 && azimuth < 2.0) {
      EXPECT_EQ(raw.time_offset_s[i] < 0, GetParam());
    }
  }
  EXPECT_GT(moved, 0.4);
}

INSTANTIATE_TEST_SUITE_P(BothWays, SpinTest, ::testing::Bool());

TEST(LidarSensorTest, SameForAnyNumberOfThreads) {
  const Scene scene(Room(Material::kCarGlass));
  const LidarSensor sensor(Model(), {});
  const SceneView view = scene.View(-0.05, 0.05);
  const LidarScan one = sensor.Scan(view, Standing(), Executor(1));
  const LidarScan two = sensor.Scan(view, Standing(), Executor(2));
  EXPECT_EQ(one.points, two.points);
  EXPECT_EQ(one.intensity, two.intensity);
  LidarSweep next = Standing();
  next.frame = 1;
  EXPECT_NE(sensor.Scan(view, next, Executor(1)).points, one.points);
}

TEST(LidarSensorTest, GlassReturnsLittle) {
  const LidarSensor sensor(Model(), {});
  const Scene plaster(Room(Material::kPlaster)), glass(Room(Material::kCarGlass));
  const size_t from_plaster =
      sensor.Scan(plaster.View(-0.05, 0.05), Standing(), Executor(1)).size();
  const size_t from_glass = sensor.Scan(glass.View(-0.05, 0.05), Standing(), Executor(1)).size();
  EXPECT_GT(from_plaster, 8U * 2083U * 95 / 100);
  EXPECT_LT(from_glass, 8U * 2083U * 70 / 100);
}

TEST(LidarSensorTest, OwnCarHidesLowBeams) {
  EXPECT_TRUE(IsHiddenByCar(0.0, 63));
  EXPECT_TRUE(IsHiddenByCar(355.0, 62));
  EXPECT_TRUE(IsHiddenByCar(185.0, 56));
  EXPECT_FALSE(IsHiddenByCar(0.0, 50));
  EXPECT_FALSE(IsHiddenByCar(90.0, 63));
}

TEST(LidarSensorTest, BadOptionsNameTheField) {
  LidarSensorOptions options;
  options.columns = 3;
  EXPECT_THROW(LidarSensor(Model(), options), InputError);
  EXPECT_THROW(LidarSensor(LidarModel(), {}), InputError) << "no beams";
}

}  // namespace
}  // namespace tvl::sim
