// Real scans for tests: only through the environment variable TVL_TEST_DATA.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "tvl/base/check.h"
#include "tvl/sensor/lidar_scan.h"

namespace tvl::test {

// Reads a KITTI scan file (float32 x y z intensity); throws InputError if it is not there.
inline LidarScan ReadKittiScan(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  TVL_CHECK_INPUT(in.good()) << file << ": cannot be read";
  LidarScan scan;
  float v[4];
  while (in.read(reinterpret_cast<char*>(v), sizeof(v))) {
    scan.points.emplace_back(v[0], v[1], v[2]);
    scan.intensity.push_back(v[3]);
  }
  return scan;
}

// The data folder; empty if TVL_TEST_DATA is not set (the test is then to be skipped).
inline std::string TestData() {
  const char* folder = std::getenv("TVL_TEST_DATA");
  return folder == nullptr ? "" : folder;
}

}  // namespace tvl::test
