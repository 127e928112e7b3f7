// `tvl calibrate`, and what `tvl run` says of calibrations that cannot be meant. Runs TVL_BINARY.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tvl/base/units.h"
#include "tvl/cli/test_program.h"
#include "tvl/io/kitti_calibration.h"
#include "tvl/io/profile.h"
#include "tvl/io/rig.h"
#include "tvl/io/test_data.h"
#include "tvl/io/test_folder.h"

namespace tvl {
namespace {

using testing::HasSubstr;
using testing::Not;

class CalibrateProgram : public Program {
 protected:
  // Its exit code; what it says is in out_ and err_.
  int Run(const std::string& arguments) {
    const Outcome outcome = Program::Run(arguments);
    out_ = outcome.out;
    err_ = outcome.err;
    return outcome.exit_code;
  }
  // The recording with another calibration.
  std::string RealDriveWith(const KittiCalibration& kitti, const std::string& recording) {
    std::filesystem::create_directories(folder_ / "drive");
    for (const char* part : {"velodyne", "image_2", "times.txt"}) {
      std::filesystem::create_symlink(recording + "/" + part,
                                      folder_ / (std::string("drive/") + part));
    }
    WriteOdometryCalibration(folder_ / "drive/calib.txt", kitti);
    return folder_ / "drive";
  }

  // The same in the layout of KITTI raw, in folder_.
  std::string RawDriveWith(const KittiCalibration& kitti, const std::string& recording) {
    const std::filesystem::path drive = folder_ / "drive_sync";
    for (const char* part : {"velodyne_points", "image_02"}) {
      std::filesystem::create_directories(drive / part);
    }
    std::filesystem::create_symlink(recording + "/velodyne", drive / "velodyne_points/data");
    std::filesystem::create_symlink(recording + "/image_2", drive / "image_02/data");
    std::string stamps;
    for (int i = 0; i < 50; ++i) {
      stamps += "2011-09-26 13:02:2" + std::to_string(i / 10) + "." + std::to_string(i % 10) + "\n";
    }
    folder_.Write("drive_sync/image_02/timestamps.txt", stamps);
    const Eigen::Matrix3d R = kitti.rectification.R();
    std::ostringstream cameras;
    cameras << std::setprecision(12) << "R_rect_00:";
    for (int i = 0; i < 9; ++i) cameras << " " << R(i / 3, i % 3);
    cameras << "\nP_rect_02:";
    for (int i = 0; i < 12; ++i) cameras << " " << (*kitti.P[2])(i / 4, i % 4);
    folder_.Write("calib_cam_to_cam.txt", cameras.str() + "\n");
    WriteRawExtrinsics(folder_ / "calib_velo_to_cam.txt", kitti);
    return drive.string();
  }

  std::string out_, err_;
};

TEST_F(CalibrateProgram, RefusesWhatTellsNothing) {
  WriteKittiFolder(folder_, LoadProfile("kitti"), 3);
  const std::string input = folder_.path().string();
  EXPECT_EQ(Run("calibrate " + input), 2) << "--out is missing";
  const std::string calibrate =
      "calibrate " + input + " --deskew none --out " + (folder_ / "new.txt");
  EXPECT_EQ(Run(calibrate), 2);
  EXPECT_THAT(err_, HasSubstr("cannot be told from this drive"));
  std::filesystem::remove_all(folder_ / "image_2");
  EXPECT_EQ(Run(calibrate), 2);
  EXPECT_THAT(err_, HasSubstr("no camera to calibrate"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new.txt"));
}

TEST_F(CalibrateProgram, FindsWhereTheCameraOfARealDrivePoints) {
  const auto recording = TestDataPath("sequences/kitti360_3000");
  if (!recording) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real drive";
  const KittiCalibration right = ReadOdometryCalibration(*recording + "/calib.txt");
  KittiCalibration wrong = right;
  wrong.T_cam0_lidar =
      Rigid3d(ExpSo3({DegToRad(-0.5), DegToRad(0.9), 0.0}), Eigen::Vector3d::Zero()) *
      right.T_cam0_lidar;
  const std::string drive = RealDriveWith(wrong, *recording), out = folder_ / "calib.txt";
  ASSERT_EQ(Run("calibrate " + drive + " --deskew cw --frames :32 --out " + out), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("deg further right than the calibration says (sigma 0.0"));
  EXPECT_THAT(out_, HasSubstr("deg lower than the calibration says"));
  const KittiCalibration found = ReadOdometryCalibration(out);
  // Right within what the recording's own calibration is.
  EXPECT_LT((found.T_cam0_lidar * right.T_cam0_lidar.Inverse()).RotationAngle(), DegToRad(0.35));
  for (size_t n = 0; n < 4; ++n) EXPECT_TRUE(found.P[n]->isApprox(*right.P[n], 1e-9)) << n;
}

TEST_F(CalibrateProgram, WritesARigForRecordingsOfAnotherLayout) {
  const auto recording = TestDataPath("sequences/kitti360_3000");
  if (!recording) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real drive";
  const KittiCalibration right = ReadOdometryCalibration(*recording + "/calib.txt");
  KittiCalibration wrong = right;
  wrong.T_cam0_lidar =
      Rigid3d(ExpSo3({0.0, DegToRad(0.9), 0.0}), Eigen::Vector3d::Zero()) * right.T_cam0_lidar;
  const std::string drive = RealDriveWith(wrong, *recording), rig = folder_ / "rig.yaml";
  std::filesystem::rename(drive + "/velodyne", drive + "/scans");  // no KITTI layout any more
  ASSERT_EQ(Run("calibrate " + drive + " --deskew cw --frames :32 --out " + rig), 0) << err_;
  const Rigid3d T_given = CalibrationOfCamera(right, 2).T_cam_lidar;
  EXPECT_LT((*LoadRig(rig).T_cam_lidar * T_given.Inverse()).RotationAngle(), DegToRad(0.35));
  EXPECT_EQ(Run("run " + drive + " --rig " + rig + " --frames :3 --out " + (folder_ / "out")), 0)
      << err_;
}

// The same recording in the layout of KITTI raw: the file that is written takes the place of the
// one that was read, and leaves the rectification out.
TEST_F(CalibrateProgram, WritesTheExtrinsicsOfARawDrive) {
  const auto recording = TestDataPath("sequences/kitti360_3000");
  if (!recording) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real drive";
  const KittiCalibration right = ReadOdometryCalibration(*recording + "/calib.txt");
  KittiCalibration wrong = right;
  wrong.rectification = Rigid3d(ExpSo3({0.01, -0.02, 0.005}), Eigen::Vector3d::Zero());
  wrong.T_cam0_lidar =
      Rigid3d(ExpSo3({0.0, DegToRad(0.9), 0.0}), Eigen::Vector3d::Zero()) * right.T_cam0_lidar;
  const std::string drive = RawDriveWith(wrong, *recording), out = folder_ / "found.txt";
  ASSERT_EQ(Run("calibrate " + drive + " --deskew cw --frames :32 --out " + out), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("deg further right than the calibration says (sigma 0.0"));
  std::filesystem::rename(out, folder_ / "calib_velo_to_cam.txt");
  const KittiCalibration found = ReadRawCalibration(folder_.path().string());
  EXPECT_LT((found.T_cam0_lidar * right.T_cam0_lidar.Inverse()).RotationAngle(), DegToRad(0.35));
}

// Between hedges edges have no clear answer, and poses that believe the camera follow it: they
// agreed with a camera that points 0.9 deg to either side within 0.03 deg.
TEST_F(CalibrateProgram, RunNoticesACameraThatPointsAside) {
  const auto recording = TestDataPath("sequences/kitti360_3000");
  if (!recording) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real drive";
  const KittiCalibration right = ReadOdometryCalibration(*recording + "/calib.txt");
  const std::string run = " --deskew cw --frames :32 --no-loops --out " + (folder_ / "out");
  for (const double error_deg : {0.9, -0.9, 0.0}) {
    SCOPED_TRACE(error_deg);
    KittiCalibration wrong = right;
    wrong.T_cam0_lidar = Rigid3d(ExpSo3({0.0, DegToRad(error_deg), 0.0}), Eigen::Vector3d::Zero()) *
                         right.T_cam0_lidar;
    std::filesystem::remove_all(folder_ / "drive");
    ASSERT_EQ(Run("run " + RealDriveWith(wrong, *recording) + run), 0) << err_;
    const nlohmann::json report = nlohmann::json::parse(Text(folder_ / "out/run.json"));
    const nlohmann::json& extrinsics = report.at("extrinsics");
    // Within the 0.12 deg in which three drives with this lidar agree, and the noise of the drive.
    EXPECT_NEAR(extrinsics.at("rotation_deg").at(1), -error_deg, 0.2);
    EXPECT_NEAR(extrinsics.at("rotation_deg").at(0), 0.0, 0.2);
    if (error_deg == 0.0) {
      EXPECT_THAT(out_, Not(HasSubstr("the camera points"))) << "what is right is left alone";
      EXPECT_EQ(extrinsics.at("applied_deg"), nlohmann::json({0.0, 0.0, 0.0}));
      continue;
    }
    EXPECT_NEAR(extrinsics.at("applied_deg").at(1), -error_deg, 0.2) << "and corrected";
    EXPECT_THAT(out_, HasSubstr(error_deg > 0.0 ? "deg further right" : "deg further left"));
    EXPECT_THAT(out_, HasSubstr("corrected"));
  }
}

TEST_F(CalibrateProgram, RunSaysThatACalibrationIsInvertedOrMadeForOtherImages) {
  const auto recording = TestDataPath("sequences/kitti360_3000");
  if (!recording) GTEST_SKIP() << "TVL_TEST_DATA is not set: no real drive";
  const KittiCalibration right = ReadOdometryCalibration(*recording + "/calib.txt");
  KittiCalibration wrong = right;
  wrong.T_cam0_lidar = right.T_cam0_lidar.Inverse();
  const std::string run = " --deskew cw --frames :20 --no-loops --out " + (folder_ / "out");
  ASSERT_EQ(Run("run " + RealDriveWith(wrong, *recording) + run), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("Tr is the inverse of what it should be"));
  EXPECT_THAT(Text(folder_ / "out/run.json"), HasSubstr("\"fault_odd_calibration\": 1"));

  std::filesystem::remove_all(folder_ / "drive");
  wrong = right;
  for (auto& P : wrong.P) P->topRows<2>() *= 2.0;
  ASSERT_EQ(Run("run " + RealDriveWith(wrong, *recording) + run), 0) << err_;
  EXPECT_THAT(err_, HasSubstr("principal point"));
  EXPECT_THAT(err_, HasSubstr("the images are half the size P is made for"));

  std::filesystem::remove_all(folder_ / "drive");
  ASSERT_EQ(Run("run " + RealDriveWith(right, *recording) + run), 0) << err_;
  EXPECT_THAT(err_, Not(HasSubstr("calib.txt")));
}

}  // namespace
}  // namespace tvl
