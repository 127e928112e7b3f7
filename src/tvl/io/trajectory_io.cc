#include "tvl/io/trajectory_io.h"

#include <Eigen/LU>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <ostream>

#include "tvl/base/check.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

// Ground truth is printed with 7 digits; beyond this a matrix is no rotation.
constexpr double kRotationTolerance = 1e-2;

// Shortest form that reads back to the same double.
std::string Text(double value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return std::string(buffer, result.ptr);
}

Rigid3d PoseOf(const std::vector<double>& numbers, const std::string& where) {
  TVL_CHECK_INPUT(numbers.size() == 12) << where << ": want 12 numbers, has " << numbers.size();
  const Matrix34d m =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers.data());
  const Eigen::Matrix3d R = m.leftCols<3>();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  TVL_CHECK_INPUT(error < kRotationTolerance && R.determinant() > 0.0)
      << where << ": not a rotation";
  return Rigid3d::FromMatrix(m);
}

// Seconds with 9 decimals, exact for every stamp (a double is not).
std::string StampText(Timestamp stamp) {
  constexpr int64_t kNsPerSecond = 1000000000;
  const int64_t magnitude = stamp.ns < 0 ? -stamp.ns : stamp.ns;
  char buffer[48];
  std::snprintf(buffer, sizeof(buffer), "%s%lld.%09lld", stamp.ns < 0 ? "-" : "",
                static_cast<long long>(magnitude / kNsPerSecond),
                static_cast<long long>(magnitude % kNsPerSecond));
  return buffer;
}

StampedPose ParseTumLine(const std::string& line, const std::string& where) {
  const size_t begin = line.find_first_not_of(" \t");
  const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
  StampedPose pose;
  pose.stamp = ParseSeconds(line.substr(begin, end - begin), where);
  const std::vector<double> v = ParseNumbers(line.substr(end), where);
  TVL_CHECK_INPUT(v.size() == 7) << where << ": want 8 numbers, has " << v.size() + 1;
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  TVL_CHECK_INPUT(std::abs(q.norm() - 1.0) < kRotationTolerance)
      << where << ": the quaternion is not of unit length";
  pose.T_world_lidar = Rigid3d(q, Eigen::Vector3d(v[0], v[1], v[2]));
  return pose;
}

}  // namespace

std::vector<Rigid3d> ToKittiPoses(const Trajectory& trajectory, const Rigid3d& T_cam0_lidar) {
  std::vector<Rigid3d> poses;
  if (trajectory.empty()) return poses;
  const Rigid3d T_lidar_cam0 = T_cam0_lidar.Inverse();
  const Rigid3d T_first_world = trajectory.front().T_world_lidar.Inverse();
  poses.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory) {
    poses.push_back(T_cam0_lidar * (T_first_world * pose.T_world_lidar) * T_lidar_cam0);
  }
  poses.front() = Rigid3d();  // exactly, not up to rounding
  return poses;
}

std::vector<Rigid3d> ReadKittiPoses(const std::string& path) {
  std::vector<Rigid3d> poses;
  const std::vector<std::string> lines = ReadLines(path);
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::string where = LineOf(path, i);
    poses.push_back(PoseOf(ParseNumbers(lines[i], where), where));
  }
  TVL_CHECK_INPUT(!poses.empty()) << path << ": no poses";
  return poses;
}

void WriteKittiPoses(const std::string& path, const std::vector<Rigid3d>& poses) {
  WriteAtomically(path, [&](std::ostream& out) {
    for (const Rigid3d& pose : poses) {
      const Matrix34d m = pose.Matrix();
      for (int i = 0; i < 12; ++i) out << (i > 0 ? " " : "") << Text(m(i / 4, i % 4));
      out << "\n";
    }
  });
}

Trajectory ReadTumTrajectory(const std::string& path) {
  Trajectory trajectory;
  const std::vector<std::string> lines = ReadLines(path);
  for (size_t i = 0; i < lines.size(); ++i) {
    const size_t begin = lines[i].find_first_not_of(" \t");
    if (begin == std::string::npos || lines[i][begin] == '#') continue;
    StampedPose pose = ParseTumLine(lines[i], LineOf(path, i));
    pose.frame = static_cast<FrameId>(trajectory.size());
    trajectory.push_back(pose);
  }
  TVL_CHECK_INPUT(!trajectory.empty()) << path << ": no poses";
  return trajectory;
}

void WriteTumTrajectory(const std::string& path, const Trajectory& trajectory) {
  WriteAtomically(path, [&](std::ostream& out) {
    for (const StampedPose& pose : trajectory) {
      const Eigen::Vector3d& t = pose.T_world_lidar.t();
      const Eigen::Quaterniond& q = pose.T_world_lidar.q();
      out << StampText(pose.stamp);
      for (const double v : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
        out << " " << Text(v);
      out << "\n";
    }
  });
}

}  // namespace tvl
