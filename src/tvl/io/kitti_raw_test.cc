#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/io/kitti_dataset.h"
#include "tvl/io/kitti_times.h"
#include "tvl/io/profile.h"
#include "tvl/io/test_folder.h"

namespace tvl {
namespace {

using testing::HasSubstr;

constexpr char kDrive[] = "2011_09_26_drive_0009_sync";

// Frames 5..8 with camera 2; the scan of 6 and the image of 7 are missing, as in real drives.
class KittiRawFolder : public testing::Test {
 protected:
  void SetUp() override {
    const std::string drive = std::string(kDrive) + "/";
    std::string stamps;
    for (int k = 0; k < 9; ++k) {
      stamps += "2011-09-26 13:02:2" + std::to_string(k) + ".964389445\n";
      if (k < 5) continue;
      if (k != 6) {
        WriteVelodyneBin(folder_ / (drive + "velodyne_points/data/" + FileNumber(k, "bin")),
                         CylinderScan(lidar_));
      }
      std::filesystem::create_directories(folder_ / (drive + "image_02/data"));
      if (k != 7) {
        cv::imwrite(folder_ / (drive + "image_02/data/" + FileNumber(k, "png")), RampImage());
      }
    }
    folder_.Write(drive + "image_02/timestamps.txt", stamps);
    folder_.Write("calib_cam_to_cam.txt",
                  "calib_time: 09-Jan-2012 13:57:47\n"
                  "R_rect_00: 0 -1 0 1 0 0 0 0 1\n"
                  "P_rect_02: 700 0 60 45 0 700 20 0 0 0 1 0\n");
    folder_.Write("calib_velo_to_cam.txt",
                  "calib_time: 15-Mar-2012 11:37:16\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0.1 0.2 0.3\n");
  }

  TempFolder folder_;
  LidarModel lidar_ = LoadProfile("kitti");
};

TEST_F(KittiRawFolder, PairsByNumberAndCountsWhatIsMissing) {
  const KittiDataset dataset(folder_ / kDrive, lidar_);
  EXPECT_EQ(dataset.setup().name, kDrive);
  EXPECT_EQ(dataset.setup().default_deskew, Deskew::kClockwise) << "the scans are raw";
  ASSERT_EQ(dataset.size(), 4U);
  EXPECT_EQ(dataset.layout().missing_scans, 1U);
  EXPECT_EQ(dataset.layout().missing_images, 1U);
  const SensorFrame no_scan = dataset.Frame(1), no_image = dataset.Frame(2);
  EXPECT_EQ(no_scan.scan, nullptr);
  EXPECT_FALSE(no_scan.image.empty());
  EXPECT_EQ(no_scan.faults.at(0).kind, FrameFault::Kind::kMissingScan);
  EXPECT_NE(no_image.scan, nullptr);
  EXPECT_EQ(no_image.faults.at(0).kind, FrameFault::Kind::kMissingImage);
  EXPECT_EQ(dataset.Frame(1).stamp.ns - dataset.Frame(0).stamp.ns, 1000000000);
  EXPECT_EQ(dataset.Frame(0).stamp.ns % 1000000000, 964389445);
}

TEST_F(KittiRawFolder, RectifiesTheMounting) {
  const Calibration calibration =
      KittiDataset(folder_ / (std::string(kDrive) + "/"), lidar_).setup().calibration;
  // T_velo_to_cam takes (x, y, z) to (-y + 0.1, -z + 0.2, x + 0.3); R_rect_00 turns that about z.
  const Eigen::Vector3d p_cam0 = calibration.T_cam0_lidar * Eigen::Vector3d(1, 2, 3);
  EXPECT_LT((p_cam0 - Eigen::Vector3d(2.8, -1.9, 1.3)).norm(), 1e-12);
  EXPECT_LT((calibration.T_cam_lidar * Eigen::Vector3d(1, 2, 3) - p_cam0 -
             Eigen::Vector3d(45.0 / 700.0, 0, 0))
                .norm(),
            1e-12);
}

TEST_F(KittiRawFolder, CalibrationMustBeInTheDateFolder) {
  std::filesystem::remove(folder_ / "calib_velo_to_cam.txt");
  try {
    KittiDataset(folder_ / kDrive, lidar_);
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("calib_velo_to_cam.txt: cannot be read"));
  }
}

TEST(KittiTimes, RawStampsAreExact) {
  const TempFolder folder;
  const auto stamps = ReadRawTimestamps(folder.Write(
      "t.txt",
      "1970-01-01 00:00:00.000000001\n2011-09-26 13:02:25.964389445\n2012-02-29 00:00:00\n"));
  EXPECT_EQ(stamps[0].ns, 1);
  EXPECT_EQ(stamps[1].ns, 1317042145964389445);
  EXPECT_EQ(stamps[2].ns, 1330473600000000000);
  EXPECT_THROW(ReadRawTimestamps(folder.Write("t.txt", "26.9.2011\n")), InputError);
  EXPECT_THROW(ReadRawTimestamps(folder.Write("t.txt", "2011-09-26 13:02:25,5\n")), InputError);
}

TEST(KittiTimes, SecondsAreExactWhereverTheyCountFrom) {
  const TempFolder folder;
  const std::vector<std::pair<std::string, int64_t>> expected = {
      {"1317042145.964389445", 1317042145964389445},
      {"1.317042145964389445e+09", 1317042145964389445},
      {"1317042145", 1317042145000000000},
      {" 1317042145.9643894454999 ", 1317042145964389445},
      {"1317042145.9643894455", 1317042145964389446},
      {"-1317042145.000000001", -1317042145000000001},
      {"+8.999999999E9", 8999999999000000000},
      {"1.036224e-01", 103622400},
      {"123e-9", 123},
      {"5e-10", 1},
      {"4e-10", 0},
      {"1e-300", 0},
      {"0e99", 0},
      {".5", 500000000}};
  std::string text;
  for (const auto& [word, ns] : expected) text += word + "\n";
  const std::vector<Timestamp> stamps = ReadOdometryTimes(folder.Write("times.txt", text));
  ASSERT_EQ(stamps.size(), expected.size());
  for (size_t i = 0; i < stamps.size(); ++i) {
    EXPECT_EQ(stamps[i].ns, expected[i].second) << expected[i].first;
  }
  for (const char* word : {"1317042145964389445", "0.1 0.2", "0.1s", "nan", "", "-9e9"}) {
    EXPECT_THROW(ReadOdometryTimes(folder.Write("t.txt", std::string(word) + "\n0\n")), InputError)
        << word;
  }
}

TEST(CountAzimuthTurns, CountsNetTurnsEitherWay) {
  for (const double sign : {1.0, -1.0}) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 1000; ++i) {
      // Five turns with jitter that crosses the seam back and forth.
      const double a = sign * (2.0 * kPi * i / 200.0 + (i % 2 == 0 ? 0.05 : 0.0) + 0.01);
      points.emplace_back(static_cast<float>(std::cos(a)), static_cast<float>(std::sin(a)), 0.0F);
    }
    EXPECT_NEAR(CountAzimuthTurns(points), 5, 1);
  }
  EXPECT_EQ(CountAzimuthTurns({}), 0);
}

}  // namespace
}  // namespace tvl
