#include "tvl/lidar/range_image.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/lidar/test_scene.h"

namespace tvl {
namespace {

RangeImageResult Build(const LidarScan& scan, const LidarModel& model,
                       Deskew deskew = Deskew::kNone) {
  const ScanGeometry geometry = ComputeScanGeometry(scan);
  return BuildRangeImage(scan, geometry, RecoverRings(scan, geometry, model, {}), model, deskew);
}

// Points on ring 10 at azimuths in degrees, 10 m away.
LidarScan OnRing(const std::vector<double>& azimuth_deg) {
  LidarScan scan;
  for (const double a : azimuth_deg) {
    scan.points.emplace_back(10.0 * std::cos(DegToRad(a)), 10.0 * std::sin(DegToRad(a)), 0.0);
    scan.ring.push_back(10);
  }
  return scan;
}

TEST(FastAtan2, AgreesWithTheLibrary) {
  for (double a = -kPi + 1e-3; a < kPi; a += 1e-3) {
    const float x = static_cast<float>(3.0 * std::cos(a)),
                y = static_cast<float>(3.0 * std::sin(a));
    EXPECT_NEAR(FastAtan2(y, x), std::atan2(y, x), 2e-5);
  }
  EXPECT_EQ(FastAtan2(0.0f, 0.0f), 0.0f);
}

TEST(RangeImage, LeftIsLeftAndTheMiddleFacesForward) {
  const RangeImageResult r =
      Build(OnRing({179.95, 90.0, 0.01, -0.01, -90.0, -179.95}), test::Hdl64());
  const RangeImage& image = r.scan.image;
  EXPECT_EQ(image.rows, 64);
  EXPECT_EQ(image.columns, 2048);
  const std::vector<int> expected = {0, 512, 1023, 1024, 1536, 2047};
  for (size_t i = 0; i < expected.size(); ++i) {
    const size_t cell = image.Index(10, expected[i]);
    ASSERT_EQ(image.point[cell], static_cast<int32_t>(i)) << "column " << expected[i];
    EXPECT_NEAR(image.range_m[cell], 10.0f, 1e-4f);
  }
  EXPECT_EQ(image.point[image.Index(9, 512)], RangeImage::kNoPoint);
  EXPECT_EQ(r.scan.ring, std::vector<uint16_t>(6, 10));
}

TEST(RangeImage, NearestOfACellStays) {
  LidarScan scan = OnRing({0.05, 0.06, 0.07});
  scan.points[0] *= 2.0f;
  scan.points[2] *= 3.0f;
  scan.intensity = {0.1f, 0.2f, 0.3f};
  const RangeImageResult r = Build(scan, test::Hdl64());
  ASSERT_EQ(r.scan.size(), 1u);
  EXPECT_EQ(r.hidden, 2);
  EXPECT_NEAR(r.scan.points[0].norm(), 10.0f, 1e-4f);
  EXPECT_EQ(r.scan.intensity[0], 0.2f);
}

TEST(RangeImage, UnusablePointsAreCountedAndDropped) {
  LidarScan scan = OnRing({10.0, 20.0, 30.0, 40.0, 50.0});
  scan.points[0].z() = std::nanf("");
  scan.points[1].x() = INFINITY;
  scan.points[2] *= 0.05f;
  scan.points[3] *= 20.0f;
  const RangeImageResult r = Build(scan, test::Hdl64());
  EXPECT_EQ(r.not_finite, 2);
  EXPECT_EQ(r.out_of_range, 2);
  EXPECT_EQ(r.scan.size(), 1u);
}

TEST(RangeImage, VerticalCorrectionRaisesPoints) {
  LidarModel model = test::Hdl64();
  model.vertical_correction_rad = DegToRad(0.205);
  LidarScan scan = OnRing({0.0, 77.0, -140.0});
  for (size_t i = 0; i < 3; ++i) scan.points[i].z() = static_cast<float>(i) - 2.0f;
  const RangeImageResult r = Build(scan, model);
  for (const Eigen::Vector3f& raised : r.scan.points) {
    const auto original = std::min_element(
        scan.points.begin(), scan.points.end(),
        [&](const auto& a, const auto& b) { return (a - raised).norm() < (b - raised).norm(); });
    const auto elevation = [](const Eigen::Vector3f& p) {
      return std::atan2(p.z(), p.head<2>().norm());
    };
    EXPECT_NEAR(elevation(raised) - elevation(*original), DegToRad(0.205), 1e-6);
    EXPECT_NEAR(raised.norm(), original->norm(), 1e-5);
    EXPECT_NEAR(std::atan2(raised.y(), raised.x()), std::atan2(original->y(), original->x()), 1e-6);
  }
}

TEST(RangeImage, TimeFromAzimuthAndSpin) {
  const LidarScan scan = OnRing({90.0, 0.0, -90.0, -179.9});
  const auto times = [&](Deskew deskew) {
    return Build(scan, test::Hdl64(), deskew).scan.time_offset_s;
  };
  EXPECT_EQ(times(Deskew::kNone), std::vector<float>(4, 0.0f));
  const std::vector<float> ccw = times(Deskew::kCounterClockwise);
  const std::vector<float> cw = times(Deskew::kClockwise);
  const std::vector<double> expected = {0.025, 0.0, -0.025, -0.05};  // left is later
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(ccw[i], expected[i], 1e-4);
    EXPECT_NEAR(cw[i], -expected[i], 1e-4);
  }
}

TEST(RangeImage, TheScansOwnTimesWin) {
  LidarScan scan = OnRing({90.0, 0.0});
  scan.time_offset_s = {0.011f, 0.012f};
  EXPECT_EQ(Build(scan, test::Hdl64(), Deskew::kClockwise).scan.time_offset_s, scan.time_offset_s);
  EXPECT_EQ(Build(scan, test::Hdl64(), Deskew::kNone).scan.time_offset_s,
            std::vector<float>(2, 0.0f));
}

TEST(RangeImage, PointsAreOrderedByRowAndColumn) {
  const auto scan =
      test::Scan({test::Plane({0, 0, 1}, -1.7), test::Plane({1, 0, 0}, 20.0)}, test::Hdl64());
  const RangeImageResult r = Build(scan.scan, test::Hdl64());
  int32_t next = 0;
  for (const int32_t point : r.scan.image.point) {
    if (point != RangeImage::kNoPoint) {
      ASSERT_EQ(point, next++);
    }
  }
  EXPECT_EQ(static_cast<size_t>(next), r.scan.size());
  EXPECT_GT(r.scan.size(), 30000u);
}

}  // namespace
}  // namespace tvl
