#include "tvl/lidar/ring_recovery.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "tvl/base/check.h"
#include "tvl/lidar/real_scans.h"
#include "tvl/lidar/ring_alignment.h"
#include "tvl/lidar/test_scene.h"

namespace tvl {
namespace {

using test::Hdl64;
using test::SimulatedScan;

RingAssignment Recover(const LidarScan& scan, const LidarModel& model = Hdl64(),
                       RingMemory* memory = nullptr) {
  return RecoverRings(scan, ComputeScanGeometry(scan), model, RingRecoveryOptions{}, memory);
}

// A street: ground and two walls, 64 full rings but for the sky.
SimulatedScan Street() {
  return test::Scan(
      {test::Plane({0, 0, 1}, -1.73), test::Plane({0, 1, 0}, 9.0), test::Plane({0, 1, 0}, -8.0),
       test::Plane({1, 0, 0}, 60.0), test::Plane({1, 0, 0}, -60.0)},
      Hdl64());
}

// The scan without the points for which `drop` holds.
SimulatedScan Without(const SimulatedScan& full,
                      const std::function<bool(uint16_t ring, float azimuth_rad)>& drop) {
  SimulatedScan out;
  for (size_t i = 0; i < full.ring.size(); ++i) {
    const Eigen::Vector3f& p = full.scan.points[i];
    if (drop(full.ring[i], std::atan2(p.y(), p.x()))) continue;
    out.scan.points.push_back(p);
    out.ring.push_back(full.ring[i]);
  }
  return out;
}

TEST(RingRecovery, FullScanIsOneToOne) {
  const SimulatedScan street = Street();
  const RingAssignment rings = Recover(street.scan);
  EXPECT_EQ(rings.source, RingSource::kOneToOne);
  EXPECT_EQ(rings.rings_found, 64);
  EXPECT_EQ(rings.rows, 64);
  EXPECT_EQ(rings.row, street.ring);
}

TEST(RingRecovery, PointsMissingAtStartAndEndOfRings) {
  // As where the own roof hides the lowest rings ahead; different on each ring.
  const SimulatedScan holes = Without(Street(), [](uint16_t ring, float azimuth) {
    return (azimuth >= 0.0f && azimuth < 0.03f * static_cast<float>(ring % 20)) ||
           (azimuth < 0.0f && azimuth > -0.04f * static_cast<float>(ring % 17));
  });
  const RingAssignment rings = Recover(holes.scan);
  EXPECT_EQ(rings.rings_found, 64);
  EXPECT_EQ(rings.row, holes.ring);
}

TEST(RingRecovery, MissingRingLeavesItsRowEmpty) {
  for (const int missing : {1, 17, 31, 32, 50, 58}) {
    const SimulatedScan fewer =
        Without(Street(), [&](uint16_t ring, float) { return ring == missing; });
    const RingAssignment rings = Recover(fewer.scan);
    EXPECT_EQ(rings.source, RingSource::kAligned);
    EXPECT_EQ(rings.rings_found, 63);
    EXPECT_EQ(rings.row, fewer.ring) << "without ring " << missing;
  }
}

TEST(RingRecovery, TruncatedFileKeepsTheUpperRows) {
  const SimulatedScan cut = Without(Street(), [](uint16_t ring, float azimuth) {
    return ring > 41 || (ring == 41 && azimuth < 0.0f);
  });
  const RingAssignment rings = Recover(cut.scan);
  EXPECT_EQ(rings.rings_found, 42);
  EXPECT_EQ(rings.rows, 64);
  EXPECT_EQ(rings.row, cut.ring);
}

// On the open road the upper beams look at the sky, those next to them hit a tree or two.
SimulatedScan OpenRoad(const SimulatedScan& scan, int first_row) {
  return Without(scan, [&](uint16_t ring, float azimuth) {
    return ring < first_row || (ring < first_row + 3 && (azimuth < 0.5f || azimuth > 1.0f));
  });
}

TEST(RingRecovery, UpperRingsInTheSkyLeaveTheirRowsEmpty) {
  for (const int first_row : {3, 8, 13, 20, 31, 40}) {
    const SimulatedScan open = OpenRoad(Street(), first_row);
    const RingAssignment rings = Recover(open.scan);
    EXPECT_EQ(rings.rings_found, 64 - first_row);
    EXPECT_EQ(rings.row, open.ring) << "without the rings above " << first_row;
  }
}

TEST(RingRecovery, BackstepsOfCompensatedScansStayInTheRing) {
  SimulatedScan street = Street();
  Rng rng(3);
  for (size_t i = 0; i < street.ring.size(); ++i) {
    Eigen::Vector3f& p = street.scan.points[i];
    const float azimuth = std::atan2(p.y(), p.x());
    // Trembling by up to 5 deg at the sides and behind, by 0.3 deg straight ahead.
    const double most = std::abs(azimuth) > 1.0f ? DegToRad(5.0) : DegToRad(0.3);
    const float turned = azimuth + static_cast<float>(rng.Uniform(-0.5, 0.5) * most);
    const float h = p.head<2>().norm();
    p.head<2>() = h * Eigen::Vector2f(std::cos(turned), std::sin(turned));
  }
  const RingAssignment rings = Recover(street.scan);
  EXPECT_EQ(rings.rings_found, 64);
  int wrong = 0;
  for (size_t i = 0; i < rings.row.size(); ++i) wrong += rings.row[i] != street.ring[i];
  EXPECT_LE(wrong, 64 * 2) << "only points that trembled across the very start may be off";
}

TEST(RingRecovery, ClockwiseStorage) {
  SimulatedScan street = Street();
  for (Eigen::Vector3f& p : street.scan.points) p.y() = -p.y();
  EXPECT_EQ(Recover(street.scan).row, street.ring);
}

TEST(RingRecovery, PointsThatSayNothingDoNotDisturb) {
  SimulatedScan street = Street();
  for (size_t i = 5; i < street.ring.size(); i += 97) street.scan.points[i].setZero();
  for (size_t i = 7; i < street.ring.size(); i += 97) street.scan.points[i].x() = std::nanf("");
  const RingAssignment rings = Recover(street.scan);
  EXPECT_EQ(rings.rings_found, 64);
  for (size_t i = 0; i < rings.row.size(); ++i) {
    if (street.scan.points[i].norm() > 0.0f) {  // false for NaN
      ASSERT_EQ(rings.row[i], street.ring[i]);
    }
  }
}

TEST(RingRecovery, GivenRingsAreUsed) {
  LidarScan scan;
  scan.points = {{5, 0, 0}, {5, 1, 0}, {5, -1, 0}};
  scan.ring = {3, 1, 3};
  const RingAssignment rings = Recover(scan);
  EXPECT_EQ(rings.source, RingSource::kGiven);
  EXPECT_EQ(rings.row, scan.ring);
  EXPECT_EQ(rings.rings_found, 2);
  scan.ring = {3, 64, 3};
  EXPECT_THROW(Recover(scan), InputError);
  LidarModel unknown = Hdl64();
  unknown.beam_elevation_rad.clear();
  EXPECT_EQ(Recover(scan, unknown).rows, 65);
}

TEST(RingRecovery, OtherOrdersOfStorageAreRefused) {
  const SimulatedScan street = Street();
  std::vector<std::pair<float, size_t>> order;  // column after column, as the sensor fires
  for (size_t i = 0; i < street.ring.size(); ++i) {
    order.emplace_back(std::atan2(street.scan.points[i].y(), street.scan.points[i].x()), i);
  }
  std::stable_sort(order.begin(), order.end());
  LidarScan scan;
  for (const auto& [azimuth, i] : order) scan.points.push_back(street.scan.points[i]);
  EXPECT_THROW(Recover(scan), InputError);
}

TEST(RingRecovery, MoreRingsThanAnyLidarHasAreRefused) {
  LidarModel unknown = Hdl64();
  unknown.beam_elevation_rad.clear();
  LidarScan scan;
  for (int i = 0; i < 6000; ++i) {  // three points a turn
    const float azimuth = 2.1f * static_cast<float>(i);
    scan.points.emplace_back(5.0f * std::cos(azimuth), 5.0f * std::sin(azimuth), 0.0f);
  }
  EXPECT_THROW(Recover(scan, unknown), InputError);
  scan.ring.assign(scan.size(), 65535);
  EXPECT_THROW(Recover(scan, unknown), InputError);
}

// Nothing but points just before the start of a ring: as if all trembled across it.
TEST(RingRecovery, AHandfulOfPointsBeforeTheStartIsARing) {
  LidarScan scan;
  for (int i = 0; i < 7; ++i)
    scan.points.emplace_back(5.0f, -0.2f + 0.01f * static_cast<float>(i), -0.1f);
  const RingAssignment rings = Recover(scan);
  EXPECT_EQ(rings.rings_found, 1);
  for (const uint16_t row : rings.row) EXPECT_LT(row, 64);
}

TEST(RingRecovery, EmptyScan) {
  const RingAssignment rings = Recover(LidarScan{});
  EXPECT_TRUE(rings.row.empty());
  EXPECT_EQ(rings.rows, 64);
}

TEST(AlignRings, CommonOffsetIsFound) {
  const std::vector<double> beams = Hdl64().beam_elevation_rad;
  // 0.15 m above the origin and 0.2 deg off; the lower, the nearer.
  std::vector<RingProfile> rings;
  for (size_t r = 0; r < beams.size(); ++r) {
    const double distance_m = 15.0 - 0.2 * static_cast<double>(r);
    if (r == 20 || r == 40) continue;
    rings.push_back({distance_m, 0.15 + distance_m * std::tan(beams[r] + DegToRad(0.2))});
  }
  const RingAlignment alignment = AlignRingsToBeams(rings, beams);
  EXPECT_NEAR(alignment.offset_rad, DegToRad(0.2), 2e-3);
  EXPECT_NEAR(alignment.origin_height_m, 0.15, 0.021);
  EXPECT_EQ(alignment.row[19], 19);
  EXPECT_EQ(alignment.row[20], 21);
  EXPECT_EQ(alignment.row[38], 39);
  EXPECT_EQ(alignment.row[39], 41);
}

TEST(AlignRings, SplitRingSharesItsRow) {
  const std::vector<double> beams = Hdl64().beam_elevation_rad;
  std::vector<RingProfile> rings;
  for (const double beam : beams) rings.push_back({10.0, 10.0 * std::tan(beam)});
  rings.insert(rings.begin() + 10, rings[10]);
  const RingAlignment alignment = AlignRingsToBeams(rings, beams);
  EXPECT_EQ(alignment.row[10], 10);
  EXPECT_EQ(alignment.row[11], 10);
  EXPECT_EQ(alignment.row[64], 63);
}

TEST(RingRecovery, RealScansHave64Rings) {
  const std::string data = test::TestData();
  if (data.empty()) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  for (const char* name :
       {"kitti360_3000/velodyne/000020.bin", "kitti_2011_09_26_0052/velodyne/000007.bin",
        "kitti_odometry_00_first10/velodyne/000003.bin"}) {
    const LidarScan scan = test::ReadKittiScan(data + "/sequences/" + name);
    const RingAssignment rings = Recover(scan);
    EXPECT_EQ(rings.rings_found, 64) << name;
    // The median elevation falls from ring to ring: no ring was split or joined.
    std::vector<std::vector<float>> elevation(64);
    for (size_t i = 0; i < scan.size(); ++i) {
      const Eigen::Vector3f& p = scan.points[i];
      elevation[rings.row[i]].push_back(std::atan2(p.z(), p.head<2>().norm()));
    }
    float above = 1.0f;
    for (std::vector<float>& e : elevation) {
      std::nth_element(e.begin(), e.begin() + static_cast<std::ptrdiff_t>(e.size() / 2), e.end());
      EXPECT_LT(e[e.size() / 2], above) << name;
      above = e[e.size() / 2];
    }
  }
}

TEST(RingRecovery, RealScansCutOffKeepTheirRows) {
  const std::string data = test::TestData();
  if (data.empty()) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  for (const char* name :
       {"kitti360_3000/velodyne/000045.bin", "kitti_2011_09_26_0052/velodyne/000007.bin",
        "kitti_odometry_00_first10/velodyne/000003.bin"}) {
    const LidarScan scan = test::ReadKittiScan(data + "/sequences/" + name);
    const RingAssignment full = Recover(scan);
    for (const size_t rings : {8u, 20u, 33u, 50u, 60u, 61u, 62u, 63u}) {
      LidarScan cut;
      for (size_t i = 0; i < scan.size() && full.row[i] < rings; ++i) {
        cut.points.push_back(scan.points[i]);
      }
      const RingAssignment found = Recover(cut);
      EXPECT_EQ(static_cast<size_t>(found.rings_found), rings);
      EXPECT_TRUE(std::equal(found.row.begin(), found.row.end(), full.row.begin()))
          << name << " cut after " << rings << " rings";
    }
  }
}

// What is missing is told by another scan of the drive that was complete.
TEST(RingRecovery, RealScansUnderAnEmptySkyKeepTheirRows) {
  const std::string data = test::TestData();
  if (data.empty()) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  for (const auto& [name, earlier, later] :
       {std::tuple{"kitti360_3000", "000020.bin", "000045.bin"},
        std::tuple{"kitti_2011_09_26_0052", "000000.bin", "000007.bin"},
        std::tuple{"kitti_2011_09_26_0013_first16", "000003.bin", "000012.bin"},
        std::tuple{"kitti_odometry_00_first10", "000000.bin", "000009.bin"}}) {
    const std::string folder = data + "/sequences/" + name + "/velodyne/";
    RingMemory memory;
    Recover(test::ReadKittiScan(folder + earlier), Hdl64(), &memory);
    ASSERT_EQ(memory.complete.size(), 64u) << name;
    SimulatedScan full;
    full.scan = test::ReadKittiScan(folder + later);
    full.ring = Recover(full.scan).row;
    for (const int first_row : {3, 8, 13, 20, 30}) {
      const SimulatedScan open = OpenRoad(full, first_row);
      EXPECT_EQ(Recover(open.scan, Hdl64(), &memory).row, open.ring)
          << name << " without the rings above " << first_row;
    }
  }
}

}  // namespace
}  // namespace tvl
