// For tests: a small drive in the KITTI odometry layout, to be broken piece by piece.
#pragma once

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tvl/base/units.h"
#include "tvl/io/temp_folder.h"
#include "tvl/io/velodyne_bin.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl {

inline constexpr char kTestCalibration[] =
    "P0: 700 0 60 0 0 700 20 0 0 0 1 0\n"
    "P2: 700 0 60 45 0 700 20 -0.2 0 0 1 0.004\n"
    "Tr: 0 -1 0 0.01 0 0 -1 -0.05 1 0 0 -0.3\n";

inline std::string FileNumber(int number, const char* extension) {
  char name[32];
  std::snprintf(name, sizeof(name), "%06d.%s", number, extension);
  return name;
}

// Every beam of the model once around, 200 columns, on a cylinder of 10 m; top ring first.
inline LidarScan CylinderScan(const LidarModel& lidar) {
  LidarScan scan;
  for (const double elevation_rad : lidar.beam_elevation_rad) {
    for (int column = 0; column < 200; ++column) {
      const double azimuth_rad = 2.0 * kPi * (column + 0.5) / 200.0;
      const Eigen::Vector3d p(10.0 * std::cos(azimuth_rad), 10.0 * std::sin(azimuth_rad),
                              10.0 * std::tan(elevation_rad));
      scan.points.push_back(p.cast<float>());
      scan.intensity.push_back(0.25F);
    }
  }
  return scan;
}

// Brightness grows to the right.
inline cv::Mat RampImage(int width_px = 120, int height_px = 40) {
  cv::Mat image(height_px, width_px, CV_8UC1);
  for (int u = 0; u < width_px; ++u) image.col(u) = cv::Scalar(2 * u % 256);
  return image;
}

// Frames 0 .. frames-1 at 10 Hz with scans and images of camera 2, calibration, times and truth
// (1 m ahead a frame).
inline void WriteKittiFolder(const TempFolder& folder, const LidarModel& lidar, int frames) {
  std::string times, poses;
  std::filesystem::create_directories(folder / "image_2");
  for (int k = 0; k < frames; ++k) {
    WriteVelodyneBin(folder / ("velodyne/" + FileNumber(k, "bin")), CylinderScan(lidar));
    cv::imwrite(folder / ("image_2/" + FileNumber(k, "png")), RampImage());
    times += std::to_string(0.1 * k) + "\n";
    poses += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(k) + "\n";
  }
  folder.Write("calib.txt", kTestCalibration);
  folder.Write("times.txt", times);
  folder.Write("poses.txt", poses);
}

}  // namespace tvl
