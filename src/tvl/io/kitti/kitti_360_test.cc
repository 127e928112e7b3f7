#include "tvl/io/kitti/kitti_360.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/io/cloud/test_bytes.h"
#include "tvl/io/test_folder.h"

namespace tvl {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr char kDrive[] = "2013_05_28_drive_0000_sync";

// Camera 0 looks along the lidar's x from (0.8, -0.1, -0.2): T_velo_cam0. The rectification turns
// by 90 deg about the optical axis (x to y).
void WriteCalibration(const TempFolder& folder) {
  folder.Write("calibration/calib_cam_to_velo.txt", "0 0 1 0.8 -1 0 0 -0.1 0 -1 0 -0.2\n");
  folder.Write("calibration/perspective.txt",
               "calib_time: 25-Nov-2018\nS_rect_00: 120 40\n"
               "R_rect_00: 0 -1 0 1 0 0 0 0 1\n"
               "P_rect_00: 550 0 60 0 0 550 20 0 0 0 1 0\n"
               "P_rect_01: 550 0 60 -330 0 550 20 0 0 0 1 0\n");
  folder.Write("calibration/calib_cam_to_pose.txt",
               "image_00: 0 0 1 1.5 1 0 0 0 0 1 0 0\nimage_01: 0 0 1 1.5 1 0 0 0.6 0 1 0 0\n");
}

void WriteDrive(const TempFolder& folder, int camera) {
  const std::string scans = "data_3d_raw/" + std::string(kDrive) + "/velodyne_points/";
  const std::string images =
      "data_2d_raw/" + std::string(kDrive) + "/image_0" + std::to_string(camera) + "/";
  std::filesystem::create_directories(folder / (images + "data_rect"));
  for (const int k : {1, 3}) {
    folder.Write(scans + "data/" + FileNumber(k, "bin"), Bytes(1.0F, 2.0F, 3.0F, 0.5F));
    cv::imwrite(folder / (images + "data_rect/" + FileNumber(k, "png")), RampImage());
  }
  std::string scan_times, image_times;
  for (int k = 0; k < 4; ++k) {
    scan_times += "2013-05-28 08:46:02.90000000" + std::to_string(k) + "\n";
    image_times += "2013-05-28 08:46:02.95000000" + std::to_string(k) + "\n";
  }
  folder.Write(scans + "timestamps.txt", scan_times);
  folder.Write(images + "timestamps.txt", image_times);
  WriteCalibration(folder);
}

TEST(Kitti360, ReadsScansImagesAndStampsByNumber) {
  const TempFolder folder;
  WriteDrive(folder, 0);
  for (const std::string& path : {folder / "", folder / ("data_3d_raw/" + std::string(kDrive))}) {
    ASSERT_TRUE(LooksLikeKitti360(path));
    const Recording recording = OpenKitti360(path);
    EXPECT_EQ(recording.name, kDrive);
    ASSERT_EQ(recording.scans->size(), 2U);
    ASSERT_EQ(recording.images->size(), 2U);
    EXPECT_EQ(recording.scans->Stamp(1)->ns % 1000000000, 900000003);
    EXPECT_EQ(recording.images->Stamp(0)->ns % 1000000000, 950000001);
    EXPECT_EQ(recording.scans->Read(0).scan->points.at(0), Eigen::Vector3f(1.0F, 2.0F, 3.0F));
    EXPECT_EQ(recording.images->Read(0).image.cols, 120);
    EXPECT_EQ(recording.camera->fx_px, 550.0);
    EXPECT_EQ(recording.camera->height_px, 40);
    EXPECT_THAT(recording.warnings, IsEmpty());
  }
}

TEST(Kitti360, ExtrinsicsLeadIntoTheRectifiedCamera) {
  const Eigen::Vector3d p_lidar(10.8, 0.9, 1.8);
  // 10 m ahead of camera 0, 1 m to its left (x = -1), 2 m above it (y = -2); rectified by
  // (x, y) -> (-y, x); camera 1 is 0.6 m to the right of camera 0.
  for (const int camera : {0, 1}) {
    const TempFolder folder;
    WriteDrive(folder, camera);
    const Recording recording = OpenKitti360(folder / "");
    const Eigen::Vector3d p = *recording.T_cam_lidar * p_lidar;
    const Eigen::Vector3d expected(2.0 - 0.6 * camera, -1.0, 10.0);
    EXPECT_TRUE(p.isApprox(expected, 1e-9)) << p.transpose();
  }
}

TEST(Kitti360, ReadsPosesOfCameras) {
  const TempFolder folder;
  WriteCalibration(folder);
  const Kitti360Calibration calibration = ReadKitti360Calibration(folder / "calibration");
  ASSERT_TRUE(calibration.T_pose_cam[1].has_value());
  EXPECT_TRUE(calibration.T_pose_cam[1]->t().isApprox(Eigen::Vector3d(1.5, 0.6, 0.0)));
  std::filesystem::remove(folder / "calibration/calib_cam_to_pose.txt");
  EXPECT_FALSE(ReadKitti360Calibration(folder / "calibration").T_pose_cam[0].has_value());
}

TEST(Kitti360, IsLidarOnlyWithoutImages) {
  const TempFolder folder;
  WriteDrive(folder, 0);
  std::filesystem::remove_all(folder / "data_2d_raw");
  const Recording recording = OpenKitti360(folder / "");
  EXPECT_EQ(recording.images, nullptr);
  EXPECT_TRUE(recording.T_cam_lidar.has_value());
  EXPECT_THAT(recording.warnings, Contains(HasSubstr("lidar only")));
}

TEST(Kitti360, RefusesWhatIsMissingOrMalformed) {
  const TempFolder folder;
  const std::string root = folder.path().string();
  const auto error = [&] { return InputErrorOf([&] { OpenKitti360(root); }); };
  EXPECT_FALSE(LooksLikeKitti360(root));
  EXPECT_THAT(error(), StartsWith(root + ": no data_3d_raw"));
  WriteDrive(folder, 0);
  const std::string velo =
      folder.Write("calibration/calib_cam_to_velo.txt", "1 0 0 0 0 1 0 0 0 0 1\n");
  EXPECT_THAT(error(), StartsWith(velo + ":1: want 12 numbers"));
  folder.Write("calibration/calib_cam_to_velo.txt", "2 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_THAT(error(), HasSubstr("not a rotation"));
  std::filesystem::remove(velo);
  EXPECT_THAT(error(), StartsWith(velo));
  const std::string drive = "data_3d_raw/" + std::string(kDrive) + "/velodyne_points/";
  folder.Write(drive + "timestamps.txt", "2013-05-28 08:46:02.9\n");
  EXPECT_THAT(error(), HasSubstr("has 1 lines, none for"));
  std::filesystem::remove_all(folder / (drive + "data"));
  EXPECT_THAT(error(), HasSubstr("no scans"));
  std::filesystem::create_directories(folder / "data_3d_raw/other/velodyne_points");
  EXPECT_THAT(error(), HasSubstr("several drives"));
}

}  // namespace
}  // namespace tvl
