#include "tvl/io/point_cloud_io.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

// More points than are written at once.
MapCloud RandomCloud() {
  Rng rng(1);
  MapCloud cloud;
  for (int i = 0; i < 70000; ++i) {
    cloud.points.emplace_back(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                              static_cast<float>(rng.Normal()));
    cloud.intensity.push_back(static_cast<float>(rng.Uniform()));
  }
  return cloud;
}

TEST(PointCloudIo, RoundTripsAreExact) {
  const TempFolder folder;
  const MapCloud cloud = RandomCloud();
  WritePcd(folder / "map.pcd", cloud);
  WritePly(folder / "map.ply", cloud);
  for (const MapCloud& read : {ReadPcd(folder / "map.pcd"), ReadPly(folder / "map.ply")}) {
    EXPECT_EQ(read.points, cloud.points);
    EXPECT_EQ(read.intensity, cloud.intensity);
  }
}

TEST(PointCloudIo, AnEmptyMapIsAMap) {
  const TempFolder folder;
  WritePcd(folder / "map.pcd", {});
  WritePly(folder / "map.ply", {});
  EXPECT_TRUE(ReadPcd(folder / "map.pcd").points.empty());
  EXPECT_TRUE(ReadPly(folder / "map.ply").points.empty());
}

TEST(PointCloudIo, RefusesBrokenFiles) {
  const TempFolder folder;
  WritePcd(folder / "map.pcd", RandomCloud());
  std::filesystem::resize_file(folder / "map.pcd", 5000);
  EXPECT_THROW(ReadPcd(folder / "map.pcd"), InputError);
  EXPECT_THROW(ReadPly(folder / "map.pcd"), InputError);
  EXPECT_THROW(ReadPcd(folder / "none.pcd"), InputError);
  EXPECT_THROW(ReadPcd(folder.Write("x.pcd", "FIELDS x y z rgb\nPOINTS 0\nDATA binary\n")),
               InputError);
  EXPECT_THROW(ReadPly(folder.Write("x.ply", "ply\nformat ascii 1.0\nend_header\n")), InputError);
  EXPECT_THROW(WritePcd(folder / "bad.pcd", {{Eigen::Vector3f::Zero()}, {}}), Error);
}

}  // namespace
}  // namespace tvl
