#include "tvl/io/cloud/cloud_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tvl/io/cloud/test_bytes.h"
#include "tvl/io/profile.h"
#include "tvl/io/test_folder.h"

namespace tvl {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;
using Kind = FrameFault::Kind;

// One point at x.
std::string Pcd(float x) {
  return "FIELDS x y z\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n" + std::to_string(x) + " 0 0\n";
}

float FirstX(const Recording& recording, size_t index) {
  const RawScanRead read = recording.scans->Read(index);
  return read.scan == nullptr ? -1.0F : read.scan->points.at(0).x();
}

std::string OpenError(const std::string& path) {
  return InputErrorOf([&] { OpenCloudFolder(path); });
}

void WriteImage(const TempFolder& folder, const std::string& name) {
  std::filesystem::create_directories(std::filesystem::path(folder / name).parent_path());
  cv::imwrite(folder / name, RampImage());
}

TEST(CloudFolder, ReadsScansInNaturalOrder) {
  const TempFolder folder;
  for (const int k : {1, 2, 10}) {
    folder.Write("clouds/" + std::to_string(k) + ".pcd", Pcd(static_cast<float>(k)));
  }
  ASSERT_TRUE(LooksLikeCloudFolder(folder.path().string()));
  const Recording recording = OpenCloudFolder(folder.path().string());
  ASSERT_EQ(recording.scans->size(), 3U);
  EXPECT_EQ(FirstX(recording, 1), 2.0F);
  EXPECT_EQ(FirstX(recording, 2), 10.0F);
  EXPECT_EQ(recording.scans->Stamp(0), std::nullopt);
  EXPECT_EQ(recording.images, nullptr);
  EXPECT_THAT(recording.warnings, IsEmpty());
  EXPECT_THAT(recording.notes, Contains(HasSubstr("3 files in")));
}

TEST(CloudFolder, FindsScansWhereverTheyAre) {
  for (const char* place : {"", "velodyne/", "velodyne_points/data/", "odd name/", "odd/data/"}) {
    const TempFolder folder;
    folder.Write(std::string(place) + "0.pcd", Pcd(0.0F));
    EXPECT_TRUE(LooksLikeCloudFolder(folder / "")) << place;
    EXPECT_EQ(OpenCloudFolder(folder / "").scans->size(), 1U) << place;
  }
  const TempFolder folder;
  const std::string single = folder.Write("here.pcd", Pcd(7.0F));
  EXPECT_TRUE(LooksLikeCloudFolder(single));
  EXPECT_EQ(FirstX(OpenCloudFolder(single), 0), 7.0F);
}

TEST(CloudFolder, AMapBesideTheScansIsNoScan) {
  const TempFolder folder;
  folder.Write("map.pcd", Pcd(99.0F));
  for (const char* name : {"scans/0.pcd", "scans/1.pcd", "scans/2.ply"}) folder.Write(name, Pcd(1));
  const Recording recording = OpenCloudFolder(folder.path().string());
  ASSERT_EQ(recording.scans->size(), 2U);
  EXPECT_EQ(FirstX(recording, 0), 1.0F);
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("1 .ply files are left out")));
}

TEST(CloudFolder, RefusesWhatIsNone) {
  const TempFolder folder;
  const std::string root = folder.path().string();
  EXPECT_FALSE(LooksLikeCloudFolder(root));
  EXPECT_FALSE(LooksLikeCloudFolder(folder / "none"));
  EXPECT_FALSE(LooksLikeCloudFolder(folder.Write("readme.txt", "")));
  EXPECT_THAT(OpenError(root), StartsWith(root + ": no scans"));
  EXPECT_THAT(OpenError(folder / "none"), StartsWith(folder / "none"));
  folder.Write("front one/0.pcd", Pcd(0));
  folder.Write("rear one/0.pcd", Pcd(0));
  EXPECT_FALSE(LooksLikeCloudFolder(root));
  EXPECT_THAT(OpenError(root), HasSubstr("several sub folders hold scans"));
  const TempFolder laz;
  laz.Write("0.laz", "LASF");
  EXPECT_TRUE(LooksLikeCloudFolder(laz.path().string()));
  EXPECT_THAT(OpenError(laz.path().string()), HasSubstr("LAZ"));
  const TempFolder broken;
  broken.Write("0.pcd", "no");
  EXPECT_THAT(OpenError(broken.path().string()), StartsWith(broken / "0.pcd:1:"));
}

TEST(CloudFolder, BadFilesAreFaultsOfTheirScan) {
  const TempFolder folder;
  for (int k = 0; k < 5; ++k) folder.Write(std::to_string(k) + ".pcd", Pcd(1.0F));
  folder.Write("1.pcd", "FIELDS x y z\nPOINTS 4000000000\nDATA binary\nabc");
  folder.Write("2.pcd", "");
  folder.Write("3.pcd", "FIELDS x y z\nPOINTS 0\nDATA binary\n");
  const Recording recording = OpenCloudFolder(folder.path().string());
  std::filesystem::remove(folder / "4.pcd");
  const std::vector<Kind> kinds = {Kind::kTruncatedScan, Kind::kEmptyScan, Kind::kEmptyScan,
                                   Kind::kMissingScan};
  for (size_t k = 1; k < 5; ++k) {
    const RawScanRead read = recording.scans->Read(k);
    EXPECT_EQ(read.scan, nullptr) << k;
    ASSERT_EQ(read.faults.size(), 1U) << k;
    EXPECT_EQ(read.faults[0].kind, kinds[k - 1]) << k;
    EXPECT_THAT(read.faults[0].message, StartsWith(folder / (std::to_string(k) + ".pcd")));
  }
}

TEST(CloudFolder, TakesStampsFromFilesAndNames) {
  const TempFolder beside;
  for (int k = 0; k < 3; ++k) beside.Write("lidar/" + std::to_string(k) + ".pcd", Pcd(0));
  beside.Write("timestamps.txt", "1317376000.000000001\n1317376000.1\n1317376000.2\n");
  const Recording stamped = OpenCloudFolder(beside.path().string());
  EXPECT_EQ(stamped.scans->Stamp(0)->ns, 1317376000000000001);
  EXPECT_THAT(stamped.notes, Contains(HasSubstr("timestamps.txt: seconds since 1970, 10 Hz")));

  const TempFolder named;
  named.Write("1317376000.5.pcd", Pcd(2));
  named.Write("1317376000.41.pcd", Pcd(1));
  const Recording by_name = OpenCloudFolder(named.path().string());
  EXPECT_EQ(by_name.scans->Stamp(0)->ns, 1317376000410000000);
  EXPECT_EQ(FirstX(by_name, 0), 1.0F);

  beside.Write("timestamps.txt", "0.0\n0.1\n");
  const Recording none = OpenCloudFolder(beside.path().string());
  EXPECT_EQ(none.scans->Stamp(0), std::nullopt);
  EXPECT_THAT(none.warnings, Contains(HasSubstr("no stamps of the scans: 2 stamps for 3")));
}

TEST(CloudFolder, PairsImagesByStampNameOrPosition) {
  const TempFolder stamped;
  for (int k = 0; k < 3; ++k) {
    stamped.Write("lidar/" + std::to_string(k) + ".pcd", Pcd(0));
    WriteImage(stamped, "cam0/data/" + std::to_string(1317376000010000000 + k * 50000000) + ".png");
  }
  stamped.Write("lidar/times.txt", "1317376000.0\n1317376000.1\n1317376000.2\n");
  const Recording by_stamp = OpenCloudFolder(stamped.path().string());
  ASSERT_NE(by_stamp.images, nullptr);
  EXPECT_EQ(by_stamp.images->Stamp(1)->ns, 1317376000060000000);
  EXPECT_EQ(by_stamp.images->Read(1).image.cols, 120);
  EXPECT_TRUE(by_stamp.images->Read(1).faults.empty());

  const TempFolder named;
  for (int k = 0; k < 4; ++k) named.Write("lidar/" + FileNumber(k, "pcd"), Pcd(0));
  for (const int k : {0, 1, 3}) WriteImage(named, "image_2/" + FileNumber(k, "png"));
  const Recording by_name = OpenCloudFolder(named.path().string());
  ASSERT_NE(by_name.images, nullptr);
  EXPECT_EQ(by_name.images->size(), 4U);
  EXPECT_EQ(by_name.images->Stamp(0), std::nullopt);
  ASSERT_EQ(by_name.images->Read(2).faults.size(), 1U);
  EXPECT_EQ(by_name.images->Read(2).faults[0].kind, Kind::kMissingImage);
  EXPECT_THAT(by_name.images->Read(2).faults[0].message, HasSubstr("000002.png"));
  EXPECT_THAT(by_name.warnings, Contains(HasSubstr("1 images of 4 scans are missing")));

  const TempFolder unnamed;
  for (const char* name : {"x", "y"}) {
    unnamed.Write("lidar/" + std::string(name) + ".pcd", Pcd(0));
    WriteImage(unnamed, "left/" + std::string(name) + "_left.png");
  }
  EXPECT_EQ(OpenCloudFolder(unnamed.path().string()).images->size(), 2U);
  WriteImage(unnamed, "left/z_left.png");
  const Recording left_out = OpenCloudFolder(unnamed.path().string());
  EXPECT_EQ(left_out.images, nullptr);
  EXPECT_THAT(left_out.warnings, Contains(HasSubstr("3 images and 2 scans")));
}

TEST(CloudFolder, ReadsKittiOdometry) {
  const TempFolder folder;
  WriteKittiFolder(folder, LoadProfile("kitti"), 3);
  const Recording recording = OpenCloudFolder(folder.path().string() + "/");
  ASSERT_EQ(recording.scans->size(), 3U);
  EXPECT_EQ(recording.scans->Stamp(2)->ns, 200000000);
  EXPECT_EQ(recording.scans->Read(0).scan->size(), 64U * 200U);
  EXPECT_EQ(recording.images->size(), 3U);
  ASSERT_TRUE(recording.camera.has_value());
  EXPECT_EQ(recording.camera->fx_px, 700.0);
  EXPECT_EQ(recording.camera->width_px, 120);
  // Camera 2 lies K^-1 p4 from camera 0.
  const Eigen::Vector3d t = recording.T_cam_lidar->t();
  EXPECT_NEAR(t.z(), -0.3 + 0.004, 1e-9);
  EXPECT_NEAR(t.x(), 0.01 + (45.0 - 60.0 * 0.004) / 700.0, 1e-9);
  EXPECT_THAT(recording.notes, Contains(HasSubstr("records of 4 floats: x y z intensity")));
  EXPECT_THAT(recording.warnings, IsEmpty());
}

TEST(CloudFolder, LeavesOtherCalibrationsAlone) {
  const TempFolder folder;
  folder.Write("0.pcd", Pcd(0));
  folder.Write("calib.txt", "fx = 700\n");
  const Recording recording = OpenCloudFolder(folder.path().string());
  EXPECT_FALSE(recording.T_cam_lidar.has_value());
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("the calibration is left out")));
}

}  // namespace
}  // namespace tvl
