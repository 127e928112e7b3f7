#include "tvl/io/kitti/kitti_object.h"

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

// R0_rect turns by 90 deg about z (x to y), so that leaving it out cannot go unnoticed.
std::string CalibrationText(const std::string& tx) {
  return "P0: 700 0 60 0 0 700 20 0 0 0 1 0\n"
         "P2: 700 0 60 35 0 700 20 0 0 0 1 0\n"
         "R0_rect: 0 -1 0 1 0 0 0 0 1\n"
         "Tr_velo_to_cam: 0 -1 0 " +
         tx +
         " 0 0 -1 0.2 1 0 0 0.3\n"
         "Tr_imu_to_velo: 1 0 0 0 0 1 0 0 0 0 1 0\n";
}

void WriteFrames(const TempFolder& folder, int frames) {
  std::filesystem::create_directories(folder / "training/image_2");
  for (int k = 0; k < frames; ++k) {
    folder.Write("training/velodyne/" + FileNumber(k, "bin"), Bytes(1.0F, 2.0F, 3.0F, 0.5F));
    folder.Write("training/calib/" + FileNumber(k, "txt"), CalibrationText("0.1"));
    cv::imwrite(folder / ("training/image_2/" + FileNumber(k, "png")), RampImage());
  }
}

TEST(KittiObject, AppliesTheRectification) {
  const TempFolder folder;
  WriteFrames(folder, 2);
  for (const std::string& path : {folder / "", folder / "training"}) {
    ASSERT_TRUE(LooksLikeKittiObject(path));
    const Recording recording = OpenKittiObject(path);
    ASSERT_EQ(recording.scans->size(), 2U);
    EXPECT_EQ(recording.scans->Read(1).scan->intensity.at(0), 0.5F);
    EXPECT_EQ(recording.scans->Stamp(0), std::nullopt);
    EXPECT_EQ(recording.images->size(), 2U);
    EXPECT_EQ(recording.camera->width_px, 120);
    // Camera before rectification: (-y + 0.1, -z + 0.2, x + 0.3) = (-1.9, -2.8, 1.3); rectified by
    // (x, y) -> (-y, x); camera 2 is 35 / 700 = 0.05 m on.
    const Eigen::Vector3d p = *recording.T_cam_lidar * Eigen::Vector3d(1.0, 2.0, 3.0);
    EXPECT_TRUE(p.isApprox(Eigen::Vector3d(2.8 + 0.05, -1.9, 1.3), 1e-9)) << p.transpose();
    EXPECT_THAT(recording.warnings, IsEmpty());
  }
}

TEST(KittiObject, CountsOtherCalibrations) {
  const TempFolder folder;
  WriteFrames(folder, 5);
  folder.Write("training/calib/000001.txt", CalibrationText("0.11"));
  folder.Write("training/calib/000002.txt", "nothing");
  std::filesystem::remove(folder / "training/calib/000003.txt");
  const Recording recording = OpenKittiObject(folder / "training");
  EXPECT_THAT(recording.warnings,
              Contains(HasSubstr("2 frames have another calibration and 1 have none")));
}

TEST(KittiObject, RefusesWhatIsMissingOrMalformed) {
  const TempFolder folder;
  const std::string root = folder.path().string();
  const auto error = [&] { return InputErrorOf([&] { OpenKittiObject(root); }); };
  EXPECT_FALSE(LooksLikeKittiObject(root));
  EXPECT_THAT(error(), StartsWith(root));
  WriteFrames(folder, 1);
  const std::string calib = folder.Write("training/calib/000000.txt",
                                         "P2: 1 2\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  EXPECT_THAT(error(), StartsWith(calib + ":1: P2"));
  folder.Write("training/calib/000000.txt", "Tr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  EXPECT_THAT(error(), HasSubstr("no line `R0_rect:`"));
  folder.Write("training/calib/000000.txt",
               "R0_rect: 2 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  EXPECT_THAT(error(), HasSubstr("R0_rect: not a rotation"));
  std::filesystem::remove(calib);
  EXPECT_THAT(error(), HasSubstr("no calibration of any scan"));
  std::filesystem::remove(folder / "training/velodyne/000000.bin");
  EXPECT_THAT(error(), HasSubstr("no scans"));
}

}  // namespace
}  // namespace tvl
