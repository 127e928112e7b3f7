#include "tvl/io/kitti_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <opencv2/core.hpp>

#include "tvl/base/check.h"
#include "tvl/base/parallel.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/io/profile.h"
#include "tvl/io/test_data.h"
#include "tvl/io/test_folder.h"

namespace tvl {
namespace {

using Kind = FrameFault::Kind;
using testing::ElementsAre;
using testing::HasSubstr;

// Four intact frames, a hand to break them with, and a look at what comes of it.
class KittiFolder : public testing::Test {
 protected:
  void SetUp() override { WriteKittiFolder(folder_, lidar_, 4); }
  std::string Root() const { return folder_.path().string(); }
  std::string Scan(int number) const { return folder_ / ("velodyne/" + FileNumber(number, "bin")); }
  std::string Image(int number) const { return folder_ / ("image_2/" + FileNumber(number, "png")); }
  KittiDataset Open() const { return KittiDataset(Root(), lidar_); }
  std::string OpenError() const {
    try {
      Open();
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  }
  std::vector<Kind> FaultsOf(size_t frame) const {
    std::vector<Kind> kinds;
    for (const FrameFault& fault : Open().Frame(frame).faults) kinds.push_back(fault.kind);
    return kinds;
  }

  TempFolder folder_;
  LidarModel lidar_ = LoadProfile("kitti");
};

TEST_F(KittiFolder, DeliversWhatIsThere) {
  const KittiDataset dataset = Open();
  ASSERT_EQ(dataset.size(), 4U);
  EXPECT_TRUE(dataset.setup().has_camera);
  EXPECT_TRUE(dataset.setup().warnings.empty());
  EXPECT_FALSE(dataset.setup().deskew.has_value());
  EXPECT_EQ(dataset.setup().name, folder_.path().filename().string());
  EXPECT_EQ(dataset.setup().calibration.camera.width_px, 120);
  const SensorFrame frame = dataset.Frame(2);
  EXPECT_TRUE(frame.faults.empty()) << frame.faults.front().message;
  EXPECT_EQ(frame.id, 2);
  EXPECT_EQ(frame.stamp.ns, 200000000);
  ASSERT_NE(frame.scan, nullptr);
  EXPECT_EQ(frame.scan->size(), 64U * 200U);
  EXPECT_EQ(frame.scan->points, CylinderScan(lidar_).points);
  EXPECT_EQ(frame.scan->intensity[7], 0.25F);
  EXPECT_TRUE(frame.scan->ring.empty());
  EXPECT_EQ(cv::norm(frame.image, RampImage(), cv::NORM_INF), 0.0);
  ASSERT_EQ(dataset.Truth_T_first_cam0().size(), 4U);
  EXPECT_EQ(dataset.Truth_T_first_cam0()[3].t().z(), 3.0);
}

TEST_F(KittiFolder, PlacesTheCameraByTheWholeFourthColumn) {
  const Calibration calibration = Open().setup().calibration;
  const Eigen::Vector3d p_lidar(12.0, 1.0, -0.5);
  const Eigen::Vector3d p_cam0 = calibration.T_cam0_lidar * p_lidar;
  EXPECT_TRUE(p_cam0.isApprox(Eigen::Vector3d(-0.99, 0.45, 11.7), 1e-12));
  // P2 applied to the point in camera 0 is the pixel, by definition.
  const double w = p_cam0.z() + 0.004;
  const Eigen::Vector2d px((700.0 * p_cam0.x() + 60.0 * p_cam0.z() + 45.0) / w,
                           (700.0 * p_cam0.y() + 20.0 * p_cam0.z() - 0.2) / w);
  const Eigen::Vector3d p_cam = calibration.T_cam_lidar * p_lidar;
  EXPECT_LT((calibration.camera.Project(p_cam.hnormalized()) - px).norm(), 1e-9);
  EXPECT_NEAR(p_cam.z(), w, 1e-12);
}

TEST_F(KittiFolder, UnusableFromTheStartIsAnErrorThatNamesIt) {
  EXPECT_THAT(KittiDataset(Root(), lidar_).size(), 4U);
  EXPECT_THROW(KittiDataset(Root() + "/nix", lidar_), InputError);
  folder_.Write("calib.txt", "P2: 1 2 3\n");
  EXPECT_THAT(OpenError(), HasSubstr("calib.txt:1: P2: want 12 numbers, has 3"));
  folder_.Write("calib.txt", "P2: 700 0 60 45 0 700 20 0 0 0 1 0\n");
  EXPECT_THAT(OpenError(), HasSubstr("calib.txt: no line `Tr:`"));
  folder_.Write("calib.txt", "P0: 700 0 60 0 0 700 20 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n");
  EXPECT_THAT(OpenError(), HasSubstr("no projection matrix for camera 2"));
  folder_.Write("calib.txt", "P2: 7 0 6 4 0 7 2 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 1 0 0\n");
  EXPECT_THAT(OpenError(), HasSubstr("not a rotation"));
  std::filesystem::remove(folder_ / "calib.txt");
  EXPECT_THAT(OpenError(), HasSubstr("calib.txt: cannot be read"));
}

TEST_F(KittiFolder, NoScansOrABadFirstOneIsAnError) {
  folder_.Write("velodyne/000000.bin", "");
  EXPECT_THAT(OpenError(), HasSubstr("000000.bin: no points"));
  EXPECT_THAT(OpenError(), HasSubstr("begin later, e.g. --frames 1:"));
  LidarScan cut = CylinderScan(lidar_);  // two faults: only the second makes it unusable
  cut.points.resize(20 * 200);
  cut.points[5].setConstant(std::numeric_limits<float>::quiet_NaN());
  cut.intensity.clear();
  WriteVelodyneBin(Scan(0), cut);
  EXPECT_THAT(OpenError(), HasSubstr("000000.bin: only 20 rings of 64"));
  KittiOptions later;
  later.first_frame = 1;
  EXPECT_EQ(KittiDataset(Root(), lidar_, later).size(), 4U);
  later.first_frame = 4;
  EXPECT_THROW(KittiDataset(Root(), lidar_, later), InputError);
  for (int k = 0; k < 4; ++k) std::filesystem::remove(Scan(k));
  EXPECT_THAT(OpenError(), HasSubstr("velodyne: no scans"));
}

TEST_F(KittiFolder, BrokenScansAreFaultsOfTheirFrame) {
  folder_.Write("velodyne/000001.bin", "");
  EXPECT_THAT(FaultsOf(1), ElementsAre(Kind::kEmptyScan));
  std::filesystem::resize_file(Scan(2), 16 * 12000 - 3);
  EXPECT_THAT(FaultsOf(2), ElementsAre(Kind::kTruncatedScan));
  std::filesystem::remove(Scan(2));
  EXPECT_THAT(FaultsOf(2), ElementsAre(Kind::kMissingScan));
  std::filesystem::resize_file(Scan(3), std::uintmax_t{1} << 30);  // of nothing
  EXPECT_THAT(FaultsOf(3), ElementsAre(Kind::kMissingScan));
  std::filesystem::remove(Scan(3));
  std::filesystem::create_directory(Scan(3));
  std::filesystem::remove(Image(3));
  std::filesystem::create_directory(Image(3));
  EXPECT_THAT(FaultsOf(3), ElementsAre(Kind::kMissingScan, Kind::kUnreadableImage));
  const SensorFrame frame = Open().Frame(2);
  EXPECT_EQ(frame.scan, nullptr);
  EXPECT_FALSE(frame.image.empty());
  EXPECT_THAT(frame.faults[0].message, HasSubstr("frame 2"));
  EXPECT_THAT(Open().setup().warnings, ElementsAre(HasSubstr("1 scans of 4 frames are missing")));
}

TEST_F(KittiFolder, CutOffScansAreRecognisedWhereverTheCutLies) {
  EXPECT_TRUE(FaultsOf(1).empty());
  for (const size_t rings : {50U, 44U, 32U, 20U, 3U}) {  // whole points: only the upper rings
    std::filesystem::resize_file(Scan(1), 16 * 200 * rings);
    EXPECT_THAT(FaultsOf(1), ElementsAre(Kind::kTruncatedScan)) << rings;
    EXPECT_EQ(Open().Frame(1).scan, nullptr);
  }
  LidarScan sparse;  // all rings, few points
  const LidarScan full = CylinderScan(lidar_);
  for (size_t i = 0; i < full.size(); i += 10) sparse.points.push_back(full.points[i]);
  WriteVelodyneBin(Scan(1), sparse);
  EXPECT_THAT(FaultsOf(1), ElementsAre(Kind::kTruncatedScan));
}

TEST_F(KittiFolder, SkyAboveAndABitMissingBelowIsNoFault) {
  const LidarScan full = CylinderScan(lidar_);
  LidarScan part;
  part.points.assign(full.points.begin() + 10 * 200, full.points.end() - 4 * 200);
  WriteVelodyneBin(Scan(1), part);
  EXPECT_TRUE(FaultsOf(1).empty());
}

TEST_F(KittiFolder, InvalidPointsAreDroppedAndReported) {
  LidarScan scan = CylinderScan(lidar_);
  scan.points[5].y() = std::numeric_limits<float>::quiet_NaN();
  scan.points[6].x() = std::numeric_limits<float>::infinity();
  scan.points[7].z() = 1e30F;
  WriteVelodyneBin(Scan(1), scan);
  EXPECT_THAT(FaultsOf(1), ElementsAre(Kind::kInvalidPoints));
  const SensorFrame frame = Open().Frame(1);
  ASSERT_NE(frame.scan, nullptr);
  EXPECT_EQ(frame.scan->size(), scan.size() - 3);
  EXPECT_EQ(frame.scan->intensity.size(), scan.size() - 3);
  for (Eigen::Vector3f& p : scan.points) p.setConstant(std::numeric_limits<float>::quiet_NaN());
  WriteVelodyneBin(Scan(1), scan);
  EXPECT_THAT(FaultsOf(1), ElementsAre(Kind::kInvalidPoints, Kind::kEmptyScan));
}

TEST_F(KittiFolder, BrokenImagesAreFaultsOfTheirFrame) {
  folder_.Write("image_2/000000.png", "not an image");
  cv::imwrite(Image(1), cv::Mat(40, 120, CV_8UC1, cv::Scalar(1)));
  cv::imwrite(Image(2), RampImage(121, 40));
  std::filesystem::remove(Image(3));
  EXPECT_THAT(FaultsOf(0), ElementsAre(Kind::kUnreadableImage));
  EXPECT_THAT(FaultsOf(3), ElementsAre(Kind::kMissingImage));
  EXPECT_NE(Open().Frame(3).scan, nullptr);
  // Frame 2 is the only usable image now: the size is its.
  EXPECT_THAT(FaultsOf(1), ElementsAre(Kind::kWrongSizeImage));
  cv::imwrite(Image(0), RampImage());
  cv::imwrite(Image(3), RampImage());
  EXPECT_THAT(FaultsOf(1), ElementsAre(Kind::kBlackImage));
  EXPECT_THAT(FaultsOf(2), ElementsAre(Kind::kWrongSizeImage));
  EXPECT_TRUE(Open().Frame(2).image.empty());
}

TEST_F(KittiFolder, DeliversColourAnd16BitAsTheyAre) {
  cv::Mat wide;
  RampImage().convertTo(wide, CV_16U, 200.0);
  cv::imwrite(Image(1), wide);
  cv::imwrite(Image(2), cv::Mat(40, 120, CV_8UC3, cv::Scalar(10, 20, 200)));
  cv::imwrite(Image(3), cv::Mat(40, 120, CV_8UC4, cv::Scalar(10, 20, 200, 255)));
  const KittiDataset dataset = Open();
  EXPECT_EQ(dataset.Frame(1).image.type(), CV_16UC1);
  EXPECT_EQ(dataset.Frame(2).image.type(), CV_8UC3);
  EXPECT_EQ(dataset.Frame(3).image.type(), CV_8UC3);
}

TEST_F(KittiFolder, WithoutImagesItIsLidarOnly) {
  std::filesystem::remove_all(folder_ / "image_2");
  const KittiDataset dataset = Open();
  EXPECT_FALSE(dataset.setup().has_camera);
  EXPECT_THAT(dataset.setup().warnings, ElementsAre(HasSubstr("lidar only")));
  EXPECT_TRUE(dataset.Frame(0).faults.empty());
  EXPECT_NEAR(dataset.setup().calibration.T_cam_lidar.t().z(), -0.3, 1e-12);
  KittiOptions options;
  options.camera = 2;
  EXPECT_THROW(KittiDataset(Root(), lidar_, options), InputError);
}

TEST_F(KittiFolder, TimeThatGoesBackIsAFault) {
  folder_.Write("times.txt", "0\n0.1\n0.05\n0.3\n");
  EXPECT_THAT(FaultsOf(2), ElementsAre(Kind::kTimeNotIncreasing));
  EXPECT_TRUE(FaultsOf(3).empty());
  folder_.Write("times.txt", "0\n0.1\n0.1\n0.3\n");
  EXPECT_THAT(FaultsOf(2), ElementsAre(Kind::kTimeNotIncreasing));
  folder_.Write("times.txt", "0\n0.1\n");
  EXPECT_THAT(OpenError(), HasSubstr("times.txt: has 2 lines for 4 frames"));
  folder_.Write("times.txt", "0\nnow\n0.2\n0.3\n");
  EXPECT_THAT(OpenError(), HasSubstr("times.txt:2: not a number"));
  std::filesystem::remove(folder_ / "times.txt");
  EXPECT_THAT(Open().setup().warnings, ElementsAre(HasSubstr("10 frames a second assumed")));
  EXPECT_EQ(Open().Frame(3).stamp.ns, 300000000);
}

TEST_F(KittiFolder, ReadsTheDeskewHint) {
  folder_.Write("tvl.yaml", "deskew: ccw\n");
  EXPECT_EQ(Open().setup().deskew, Deskew::kCounterClockwise);
  folder_.Write("tvl.yaml", "deskew: cw\n");
  EXPECT_EQ(Open().setup().deskew, Deskew::kClockwise);
  folder_.Write("tvl.yaml", "deskew: none\n");
  EXPECT_EQ(Open().setup().deskew, Deskew::kNone);
  folder_.Write("tvl.yaml", "deskew: left\n");
  EXPECT_THAT(OpenError(), HasSubstr("tvl.yaml:1: deskew: must be none, cw or ccw"));
  folder_.Write("tvl.yaml", "\nspin: cw\n");
  EXPECT_THAT(OpenError(), HasSubstr("tvl.yaml:2: spin: unknown key"));
}

// KITTI odometry stores compensated scans, KITTI-360 (known by the size of its images) raw ones.
TEST_F(KittiFolder, DefaultOfUndecidedDeskewingFollowsTheImages) {
  EXPECT_EQ(Open().setup().default_deskew, Deskew::kNone);
  for (int k = 0; k < 4; ++k) cv::imwrite(Image(k), RampImage(1408, 376));
  EXPECT_EQ(Open().setup().default_deskew, Deskew::kClockwise);
  EXPECT_FALSE(Open().setup().deskew.has_value()) << "a default is no statement";
}

TEST_F(KittiFolder, FramesOfAClipAreFoundByNumberInFullFiles) {
  std::filesystem::remove(Scan(0));
  std::filesystem::remove(Image(0));
  const KittiDataset dataset = Open();  // frames 1..3, times and poses of 0..3
  ASSERT_EQ(dataset.size(), 3U);
  EXPECT_EQ(dataset.Frame(0).stamp.ns, 100000000);
  EXPECT_EQ(dataset.Frame(0).id, 0);
  EXPECT_THAT(dataset.Truth_T_first_cam0()[0], Rigid3dNear(Rigid3d(), 1e-12, 1e-12));
  EXPECT_NEAR(dataset.Truth_T_first_cam0()[2].t().z(), 2.0, 1e-12);
}

TEST_F(KittiFolder, ReadsEveryFrameTheSameFromManyThreads) {
  const KittiDataset dataset = Open();
  std::vector<SensorFrame> frames(32);
  Executor(4).For(frames.size(), 1,
                  [&](size_t begin, size_t) { frames[begin] = dataset.Frame(begin % 4); });
  for (const SensorFrame& frame : frames) EXPECT_EQ(frame.scan->points, frames[0].scan->points);
}

TEST(KittiDatasetRealData, EveryFrameOfTheClipsIsWhole) {
  for (const char* name : {"kitti360_3000", "kitti_2011_09_26_0052", "kitti_odometry_00_first10"}) {
    const auto path = TestDataPath(std::string("sequences/") + name);
    if (!path) GTEST_SKIP() << "TVL_TEST_DATA is not set";
    const KittiDataset dataset(*path, LoadProfile("kitti"));
    for (size_t i = 0; i < dataset.size(); i += 7) {
      const SensorFrame frame = dataset.Frame(i);
      EXPECT_TRUE(frame.faults.empty()) << frame.faults.front().message;
      ASSERT_NE(frame.scan, nullptr);
      EXPECT_GE(CountAzimuthTurns(frame.scan->points), 62);
      EXPECT_EQ(frame.image.empty(), !dataset.setup().has_camera);
    }
  }
}

}  // namespace
}  // namespace tvl
