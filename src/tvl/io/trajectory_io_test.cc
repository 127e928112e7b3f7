#include "tvl/io/trajectory_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/temp_folder.h"
#include "tvl/io/test_data.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

Trajectory RandomTrajectory() {
  Rng rng(5);
  Trajectory trajectory;
  for (int i = 0; i < 20; ++i) {
    Vector6d xi;
    for (int j = 0; j < 6; ++j) xi[j] = rng.Uniform(-1.0, 1.0) * (j < 3 ? 1.0 : 100.0);
    trajectory.push_back({i, {1317042145964389445 + i * 103459871LL}, Rigid3d::Exp(xi)});
  }
  return trajectory;
}

std::string ErrorOfKitti(const std::string& text) {
  const TempFolder folder;
  try {
    ReadKittiPoses(folder.Write("p.txt", text));
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(TrajectoryIo, KittiRoundTrip) {
  const TempFolder folder;
  std::vector<Rigid3d> poses;
  for (const StampedPose& pose : RandomTrajectory()) poses.push_back(pose.T_world_lidar);
  WriteKittiPoses(folder / "poses.txt", poses);
  const std::vector<Rigid3d> read = ReadKittiPoses(folder / "poses.txt");
  ASSERT_EQ(read.size(), poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_THAT(read[i], Rigid3dNear(poses[i], 1e-12, 1e-12));
  }
}

TEST(TrajectoryIo, TumRoundTripKeepsEveryNanosecond) {
  const TempFolder folder;
  const Trajectory trajectory = RandomTrajectory();
  WriteTumTrajectory(folder / "t.txt", trajectory);
  const Trajectory read = ReadTumTrajectory(folder / "t.txt");
  ASSERT_EQ(read.size(), trajectory.size());
  for (size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].stamp, trajectory[i].stamp);
    EXPECT_EQ(read[i].frame, trajectory[i].frame);
    EXPECT_THAT(read[i].T_world_lidar, Rigid3dNear(trajectory[i].T_world_lidar, 1e-12, 1e-12));
  }
}

TEST(TrajectoryIo, TumFormatIsTheDocumentedOne) {
  const TempFolder folder;
  const Rigid3d T(Eigen::Quaterniond(0.0, 1.0, 0.0, 0.0), Eigen::Vector3d(1, 2, 3));
  WriteTumTrajectory(folder / "t.txt", {{0, {1500000001}, T}});
  EXPECT_THAT(ReadLines(folder / "t.txt"), testing::ElementsAre("1.500000001 1 2 3 1 0 0 0"));
  const Trajectory read = ReadTumTrajectory(folder.Write("u.txt", "# time\n2.5 1 2 3 1 0 0 0\n"));
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].stamp.ns, 2500000000);
}

TEST(TrajectoryIo, StampsSince1970KeepTheirNanoseconds) {
  const TempFolder folder;
  WriteTumTrajectory(folder / "t.txt", {{0, {1317042145964389445}, Rigid3d()}});
  EXPECT_THAT(ReadLines(folder / "t.txt").at(0), testing::StartsWith("1317042145.964389445 "));
  EXPECT_EQ(ReadTumTrajectory(folder / "t.txt").at(0).stamp.ns, 1317042145964389445);
}

TEST(TrajectoryIo, LidarMotionBecomesCameraMotion) {
  // Camera 0.5 m ahead of the lidar, axes turned the usual way: the lidar's forward is the camera's
  // z. Lidar drives 2 m ahead and turns a quarter to the left: the camera, at its nose, ends 2 m
  // minus 0.5 m ahead of where it was (z) and 0.5 m to the left (x = -0.5).
  Eigen::Matrix3d R_cam_lidar;
  R_cam_lidar << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  const Rigid3d T_cam0_lidar(R_cam_lidar, Eigen::Vector3d(0, 0, -0.5));
  const Rigid3d T_world_first(ExpSo3({0, 0, 0.7}), Eigen::Vector3d(9, 8, 7));
  const Rigid3d motion(ExpSo3({0, 0, 1.5707963267948966}), Eigen::Vector3d(2, 0, 0));
  const std::vector<Rigid3d> poses =
      ToKittiPoses({{0, {0}, T_world_first}, {1, {1}, T_world_first * motion}}, T_cam0_lidar);
  EXPECT_THAT(poses[0], Rigid3dNear(Rigid3d(), 0.0, 0.0));
  const Rigid3d expected(ExpSo3({0, -1.5707963267948966, 0}), Eigen::Vector3d(-0.5, 0, 1.5));
  EXPECT_THAT(poses[1], Rigid3dNear(expected, 1e-9, 1e-12));
}

TEST(TrajectoryIo, ErrorsNameTheLine) {
  const std::string identity = "1 0 0 0 0 1 0 0 0 0 1 0\n";
  EXPECT_THAT(ErrorOfKitti(identity + "1 2 3\n"), testing::HasSubstr("p.txt:2: want 12 numbers"));
  EXPECT_THAT(ErrorOfKitti(identity + "1 0 0 0 0 1 0 0 0 0 nan 0\n"),
              testing::HasSubstr("p.txt:2: not a number"));
  EXPECT_THAT(ErrorOfKitti("2 0 0 0 0 1 0 0 0 0 1 0\n"), testing::HasSubstr("not a rotation"));
  EXPECT_THAT(ErrorOfKitti(""), testing::HasSubstr("no poses"));
  const TempFolder folder;
  EXPECT_THROW(ReadTumTrajectory(folder.Write("t", "1 2 3 4 0 0 0 5\n")), InputError);
  EXPECT_THROW(ReadTumTrajectory(folder.Write("t", "1 2 3\n")), InputError);
  EXPECT_THROW(ReadKittiPoses(folder / "none"), InputError);
}

TEST(TrajectoryIoRealData, ReadsGroundTruth) {
  const auto path = TestDataPath("trajectories/kitti_06.txt");
  if (!path) GTEST_SKIP() << "TVL_TEST_DATA is not set";
  const std::vector<Rigid3d> poses = ReadKittiPoses(*path);
  EXPECT_EQ(poses.size(), 1101U);
  EXPECT_THAT(poses[0], Rigid3dNear(Rigid3d(), 1e-6, 1e-6));
}

TEST(WriteAtomically, LeavesNothingBehindOnFailure) {
  const TempFolder folder;
  const std::string path = folder / "sub/file.txt";
  WriteAtomically(path, [](std::ostream& out) { out << "old"; });
  EXPECT_THROW(WriteAtomically(path,
                               [](std::ostream& out) {
                                 out << "half";
                                 throw Error("stop");
                               }),
               Error);
  EXPECT_THAT(ReadLines(path), testing::ElementsAre("old"));
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry :
       std::filesystem::directory_iterator(folder.path() / "sub")) {
    ++files;
  }
  EXPECT_EQ(files, 1U);
  EXPECT_THROW(WriteAtomically(path + "/x", [](std::ostream&) {}), InputError);
}

}  // namespace
}  // namespace tvl
