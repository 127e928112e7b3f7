#include "tvl/io/kitti_dataset.h"

#include <gtest/gtest.h>

#include "tvl/io/profile.h"
#include "tvl/io/test_data.h"

namespace tvl {
namespace {

TEST(KittiDatasetRealData, Clips) {
  for (const char* name : {"kitti360_3000", "kitti_2011_09_26_0052", "kitti_odometry_00_first10"}) {
    const auto path = TestDataPath(std::string("sequences/") + name);
    if (!path) GTEST_SKIP() << "TVL_TEST_DATA is not set";
    const KittiDataset dataset(*path, LoadProfile("kitti"));
    for (size_t i = 0; i < dataset.size(); ++i) {
      const SensorFrame frame = dataset.Frame(i);
      EXPECT_TRUE(frame.faults.empty()) << frame.faults.front().message;
      ASSERT_NE(frame.scan, nullptr);
      EXPECT_GE(CountAzimuthTurns(frame.scan->points), 62);
    }
  }
}

}  // namespace
}  // namespace tvl
