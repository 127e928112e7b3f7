#include "tvl/lidar/scan_layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/lidar/test_scene.h"

namespace tvl {
namespace {

using ::testing::HasSubstr;

// A street: the road 1.7 m below the sensor, houses to both sides and the ends.
std::vector<test::Surface> Street() {
  return {test::Plane({0, 0, 1}, -1.7), test::Plane({0, 1, 0}, 8.0), test::Plane({0, 1, 0}, -6.0),
          test::Plane({1, 0, 0}, 35.0), test::Plane({1, 0, 0}, -30.0)};
}

LidarModel Beams(double top_deg, double bottom_deg, int count) {
  LidarModel model;
  model.name = "test";
  for (int i = 0; i < count; ++i) {
    model.beam_elevation_rad.push_back(
        DegToRad(top_deg + (bottom_deg - top_deg) * i / (count - 1)));
  }
  return model;
}

// A scan with the row of every point, stored ring after ring.
struct Scanned {
  RawScan raw;
  std::vector<int> row;
};

Scanned ScanWith(const LidarModel& model, int steps = 1024) {
  const test::SimulatedScan simulated = test::Scan(Street(), model, 0.01, 3, steps);
  Scanned out;
  out.raw.points = simulated.scan.points;
  out.raw.width = out.raw.points.size();
  out.row.assign(simulated.ring.begin(), simulated.ring.end());
  return out;
}

Scanned Reordered(const Scanned& scan, const std::vector<size_t>& order) {
  Scanned out;
  for (const size_t i : order) {
    out.raw.points.push_back(scan.raw.points[i]);
    out.row.push_back(scan.row[i]);
    if (!scan.raw.ring.empty()) out.raw.ring.push_back(scan.raw.ring[i]);
  }
  out.raw.width = out.raw.points.size();
  return out;
}

std::vector<size_t> Indices(const Scanned& scan) {
  std::vector<size_t> order(scan.raw.size());
  std::iota(order.begin(), order.end(), size_t{0});
  return order;
}

// As measured: all beams at one azimuth, then the next, turning clockwise from behind.
Scanned FiringByFiring(const Scanned& scan) {
  std::vector<size_t> order = Indices(scan);
  const auto azimuth = [&](size_t i) {
    return std::atan2(scan.raw.points[i].y(), scan.raw.points[i].x());
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return azimuth(a) > azimuth(b) + 1e-3; });
  return Reordered(scan, order);
}

Scanned Shuffled(const Scanned& scan) {
  std::vector<size_t> order = Indices(scan);
  Rng rng(5);
  for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[rng.Next() % (i + 1)]);
  return Reordered(scan, order);
}

ScanLayout Recognise(const RawScan& scan, const LayoutHints& hints = {}) {
  return RecogniseLayout({{&scan, {}}}, hints);
}

// Share of points whose row is the one they were measured with.
double ShareOfRightRows(const Scanned& scan, const ScanLayout& layout) {
  const LidarScan applied = ApplyLayout(scan.raw, layout, {});
  EXPECT_EQ(applied.ring.size(), scan.row.size());
  double right = 0.0;
  for (size_t i = 0; i < applied.ring.size(); ++i) right += applied.ring[i] == scan.row[i];
  return right / static_cast<double>(scan.row.size());
}

TEST(ScanLayout, FiringsOfASpinningLidarAreToldByTheirElevations) {
  const Scanned scan = FiringByFiring(ScanWith(Beams(11.0, -31.0, 32)));
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.order, ScanOrder::kElevations);
  EXPECT_EQ(layout.lidar.rows(), 32);
  EXPECT_GT(ShareOfRightRows(scan, layout), 0.999);
}

TEST(ScanLayout, FiringsTellWhenTheyWereMeasured) {
  const Scanned scan = FiringByFiring(ScanWith(Beams(15.0, -15.0, 16)));
  const ScanLayout layout = Recognise(scan.raw);
  ASSERT_EQ(layout.times, PointTimes::kFromOrder);
  EXPECT_NEAR(layout.turns_per_scan, -1.0, 0.02);
  const LidarScan applied = ApplyLayout(scan.raw, layout, {});
  ASSERT_EQ(applied.time_offset_s.size(), applied.size());
  for (size_t i = 0; i < applied.size(); i += 97) {
    const Eigen::Vector3f& p = applied.points[i];
    const double expected_s = -0.1 * std::atan2(p.y(), p.x()) / (2.0 * kPi);
    // At the ends of the sweep, which are one azimuth, the order tells which.
    if (std::abs(expected_s) > 0.0495) continue;
    EXPECT_NEAR(applied.time_offset_s[i], expected_s, 5e-4) << i;
  }
}

TEST(ScanLayout, ShuffledPointsOfBeamsThatStandApartHaveBeams) {
  const Scanned scan = Shuffled(ScanWith(Beams(15.0, -15.0, 16)));
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.order, ScanOrder::kElevations);
  EXPECT_EQ(layout.times, PointTimes::kNone);
  EXPECT_GT(ShareOfRightRows(scan, layout), 0.999);
}

TEST(ScanLayout, PointsEverywhereBetweenTheBeamsAreNoBeams) {
  RawScan scan;
  Rng rng(7);
  for (int i = 0; i < 20000; ++i) {
    const double azimuth = rng.Uniform(-kPi, kPi), elevation = rng.Uniform(-0.4, 0.4);
    scan.points.push_back(
        (10.0 * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                std::cos(elevation) * std::sin(azimuth), std::sin(elevation)))
            .cast<float>());
  }
  scan.width = scan.size();
  const ScanLayout layout = Recognise(scan);
  EXPECT_EQ(layout.order, ScanOrder::kSlices);
  EXPECT_FALSE(layout.lidar.rows_are_beams);
  EXPECT_NEAR(layout.lidar.beam_elevation_rad.front(), 0.4, 0.02);
  EXPECT_NEAR(layout.lidar.beam_elevation_rad.back(), -0.4, 0.02);
}

TEST(ScanLayout, RingsStoredTopmostFirstAreLeftToTheRecoveryOfRings) {
  const Scanned scan = ScanWith(test::Hdl64(), 2000);
  LayoutHints hints;
  hints.profiles = {test::Hdl64()};
  const ScanLayout layout = Recognise(scan.raw, hints);
  EXPECT_EQ(layout.order, ScanOrder::kRingAfterRing);
  EXPECT_FALSE(layout.lowest_first);
  EXPECT_EQ(layout.lidar.name, "HDL-64E");
  EXPECT_EQ(layout.lidar.ring_start_azimuth_rad, 0.0);
  EXPECT_TRUE(ApplyLayout(scan.raw, layout, {}).ring.empty());
}

TEST(ScanLayout, RingsStoredLowestFirstAreTurnedRound) {
  Scanned scan = ScanWith(Beams(10.0, -20.0, 24));
  std::vector<size_t> order = Indices(scan);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return scan.row[a] > scan.row[b]; });
  scan = Reordered(scan, order);
  const ScanLayout layout = Recognise(scan.raw);
  ASSERT_EQ(layout.order, ScanOrder::kRingAfterRing);
  EXPECT_TRUE(layout.lowest_first);
  EXPECT_EQ(layout.lidar.rows(), 24);
  const LidarScan applied = ApplyLayout(scan.raw, layout, {});
  EXPECT_GT(applied.points.front().z() / applied.points.front().norm(), 0.15F);
  EXPECT_LT(applied.points.back().z() / applied.points.back().norm(), -0.3F);
}

TEST(ScanLayout, ASectorBeginsWhereItsGapIs) {
  const Scanned all = ScanWith(Beams(10.0, -20.0, 24));
  std::vector<size_t> ahead;
  for (size_t i = 0; i < all.raw.size(); ++i) {
    if (all.raw.points[i].x() > 0.0F) ahead.push_back(i);
  }
  // Within each ring from right to left, as a sensor that looks ahead stores them.
  std::stable_sort(ahead.begin(), ahead.end(), [&](size_t a, size_t b) {
    const auto azimuth = [&](size_t i) {
      return std::atan2(all.raw.points[i].y(), all.raw.points[i].x());
    };
    return all.row[a] != all.row[b] ? all.row[a] < all.row[b] : azimuth(a) < azimuth(b);
  });
  const ScanLayout layout = Recognise(Reordered(all, ahead).raw);
  ASSERT_EQ(layout.order, ScanOrder::kRingAfterRing);
  EXPECT_EQ(layout.lidar.rows(), 24);
  EXPECT_GT(std::abs(layout.lidar.ring_start_azimuth_rad), 0.5 * kPi);
}

TEST(ScanLayout, RingNumbersOfAnyOrderAreSortedByElevation) {
  Scanned scan = Shuffled(ScanWith(Beams(10.0, -20.0, 24)));
  for (const int row : scan.row) scan.raw.ring.push_back(static_cast<uint16_t>((row * 7) % 24));
  scan.raw.ring_field = "channel";
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.order, ScanOrder::kRingNumbers);
  EXPECT_GT(ShareOfRightRows(scan, layout), 0.999);
}

TEST(ScanLayout, BeamsThatSeeOnlySkyAtFirstHaveRowsOfTheirOwn) {
  // Lowest beam first, as Velodyne and Ouster number them; the five topmost have no return.
  const LidarModel model = Beams(15.0, -15.0, 16);
  Scanned scan = ScanWith(model);
  for (const int row : scan.row) scan.raw.ring.push_back(static_cast<uint16_t>(15 - row));
  scan.raw.ring_field = "ring";
  std::vector<size_t> seen;
  for (size_t i = 0; i < scan.row.size(); ++i) {
    if (scan.row[i] >= 5) seen.push_back(i);
  }
  const ScanLayout layout = Recognise(Reordered(scan, seen).raw);
  ASSERT_EQ(layout.lidar.rows(), 16);
  EXPECT_NEAR(layout.lidar.beam_elevation_rad.front(), DegToRad(15.0), 0.01);
  EXPECT_GT(ShareOfRightRows(scan, layout), 0.999);
}

TEST(ScanLayout, RingNumbersThatAreNoBeamsAreSaidAndNotUsed) {
  Scanned scan = Shuffled(ScanWith(Beams(10.0, -20.0, 24)));
  for (size_t i = 0; i < scan.row.size(); ++i) {
    scan.raw.ring.push_back(static_cast<uint16_t>(i % 6));
  }
  scan.raw.ring_field = "line";
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.order, ScanOrder::kElevations);
  EXPECT_THAT(layout.notes.front(), HasSubstr("field 'line' does not number the beams"));
}

TEST(ScanLayout, ColumnsOfAnOrganisedCloudMayBeTheBeams) {
  const LidarModel model = Beams(20.0, -20.0, 16);
  const Scanned rings = ScanWith(model, 500);
  ASSERT_EQ(rings.raw.size(), 16U * 500U);
  Scanned scan;
  for (size_t column = 0; column < 500; ++column) {
    for (size_t row = 0; row < 16; ++row) {
      scan.raw.points.push_back(rings.raw.points[row * 500 + column]);
      scan.row.push_back(static_cast<int>(row));
    }
  }
  scan.raw.width = 16, scan.raw.height = 500;
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.order, ScanOrder::kOrganised);
  EXPECT_TRUE(layout.lines_are_columns);
  EXPECT_EQ(ShareOfRightRows(scan, layout), 1.0);
}

TEST(ScanLayout, PlacesWithoutReturnAreLeftOut) {
  Scanned scan = ScanWith(Beams(10.0, -20.0, 24));
  const size_t returns = scan.raw.size();
  scan.raw.points.insert(scan.raw.points.begin() + 100, 500, Eigen::Vector3f::Zero());
  scan.raw.points.insert(scan.raw.points.end(), 500, Eigen::Vector3f::Constant(std::nanf("")));
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.order, ScanOrder::kRingAfterRing);
  EXPECT_EQ(ApplyLayout(scan.raw, layout, {}).size(), returns);
}

TEST(ScanLayout, MillimetresAreToldByTheirSize) {
  Scanned scan = ScanWith(Beams(10.0, -20.0, 24));
  const float norm = scan.raw.points[10].norm();
  for (Eigen::Vector3f& p : scan.raw.points) p *= 1000.0F;
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.metres_per_unit, 1e-3);
  EXPECT_NEAR(ApplyLayout(scan.raw, layout, {}).points[10].norm(), norm, 1e-4F);
}

TEST(ScanLayout, TheProfileThatFitsIsTaken) {
  LayoutHints hints;
  hints.profiles = {test::Hdl64(), Beams(15.0, -15.0, 16), Beams(22.5, -22.5, 64)};
  hints.profiles[1].name = "sixteen", hints.profiles[2].name = "wide";
  const ScanLayout wide = Recognise(ScanWith(Beams(22.3, -22.6, 64)).raw, hints);
  EXPECT_EQ(wide.lidar.name, "wide");
  EXPECT_LT(wide.profile_rms_rad, DegToRad(0.5));
  const ScanLayout other = Recognise(ScanWith(Beams(40.0, -40.0, 64)).raw, hints);
  EXPECT_THAT(other.lidar.name, HasSubstr("as measured"));
  EXPECT_EQ(other.lidar.vertical_correction_rad, 0.0);
}

TEST(ScanLayout, AProfileOfTheUserThatDoesNotFitIsSaid) {
  LayoutHints hints;
  hints.lidar = test::Hdl64();
  hints.is_given_by_user = true;
  const ScanLayout layout = Recognise(ScanWith(Beams(22.5, -22.5, 64)).raw, hints);
  ASSERT_EQ(layout.warnings.size(), 1U);
  EXPECT_THAT(layout.warnings[0], HasSubstr("profile 'HDL-64E' does not fit"));
}

TEST(ScanLayout, ScansWithoutAnyReturnAreAnError) {
  RawScan scan;
  scan.points.assign(100, Eigen::Vector3f::Zero());
  scan.width = 100;
  EXPECT_THROW(Recognise(scan), InputError);
}

// Times in four units, from the start and the end of the sweep, and absolute.
struct TimeCase {
  const char* name;
  double unit_s;   // of the field
  double first_s;  // of the sweep's first point, after the stamp, or of its own clock
  double stamp_s;
  bool absolute;
  PointTimes expected;
};

class PointTimesTest : public ::testing::TestWithParam<TimeCase> {};

TEST_P(PointTimesTest, AreUnderstood) {
  const TimeCase& given = GetParam();
  Scanned first = FiringByFiring(ScanWith(Beams(15.0, -15.0, 16)));
  Scanned second = first;
  const Timestamp stamps[] = {Timestamp::FromSeconds(given.stamp_s),
                              Timestamp::FromSeconds(given.stamp_s + 0.1)};
  Scanned* scans[] = {&first, &second};
  for (int s = 0; s < 2; ++s) {
    RawScan& raw = scans[s]->raw;
    const double zero_s = given.absolute ? given.first_s + 0.1 * s : given.first_s;
    for (size_t i = 0; i < raw.size(); ++i) {
      raw.time.push_back((zero_s + 0.1 * static_cast<double>(i) / static_cast<double>(raw.size())) /
                         given.unit_s);
    }
    raw.time_field = "t";
  }
  const ScanLayout layout =
      RecogniseLayout({{&first.raw, stamps[0]}, {&second.raw, stamps[1]}}, LayoutHints());
  EXPECT_EQ(layout.times, given.expected);
  EXPECT_EQ(layout.s_per_time_unit, given.unit_s);
  const LidarScan applied = ApplyLayout(second.raw, layout, stamps[1]);
  const double begin_s = given.expected == PointTimes::kAbsolute   ? given.first_s - given.stamp_s
                         : given.expected == PointTimes::kOwnClock ? 0.0
                                                                   : given.first_s;
  EXPECT_NEAR(applied.time_offset_s.front(), begin_s, 1e-4);
  EXPECT_NEAR(applied.time_offset_s.back(), begin_s + 0.1, 1e-4);
}

INSTANTIATE_TEST_SUITE_P(
    Units, PointTimesTest,
    ::testing::Values(
        TimeCase{"Seconds", 1.0, 0.0, 1.6e9, false, PointTimes::kAfterStamp},
        TimeCase{"SecondsFromTheEnd", 1.0, -0.1, 1.6e9, false, PointTimes::kAfterStamp},
        TimeCase{"Milliseconds", 1e-3, 0.0, 1.6e9, false, PointTimes::kAfterStamp},
        TimeCase{"Microseconds", 1e-6, 0.0, 0.0, false, PointTimes::kAfterStamp},
        TimeCase{"Nanoseconds", 1e-9, 0.0, 1.6e9, false, PointTimes::kAfterStamp},
        TimeCase{"AbsoluteSeconds", 1.0, 1.6e9 - 0.05, 1.6e9, true, PointTimes::kAbsolute},
        TimeCase{"AbsoluteNanoseconds", 1e-9, 1.6e9, 1.6e9, true, PointTimes::kAbsolute},
        TimeCase{"SecondsFromPowerOn", 1.0, 512.0, 1.6e9, true, PointTimes::kOwnClock}),
    [](const auto& test_case) { return test_case.param.name; });

TEST(PointTimes, AFieldThatSpansNoSweepIsSaidAndNotUsed) {
  Scanned scan = Shuffled(ScanWith(Beams(15.0, -15.0, 16)));
  scan.raw.time.assign(scan.raw.size(), 1.5e9);
  scan.raw.time_field = "timestamp";
  const ScanLayout layout = Recognise(scan.raw);
  EXPECT_EQ(layout.times, PointTimes::kNone);
  ASSERT_FALSE(layout.warnings.empty());
  EXPECT_THAT(layout.warnings.back(), HasSubstr("field 'timestamp' is not used"));
}

}  // namespace
}  // namespace tvl
