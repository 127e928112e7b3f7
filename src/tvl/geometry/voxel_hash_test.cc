#include "tvl/geometry/voxel_hash.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

TEST(VoxelKey, NegativeCoordinatesRoundDown) {
  EXPECT_EQ(VoxelKey::Of({-0.1, 0.0, 1.9}, 1.0), (VoxelKey{-1, 0, 1}));
  EXPECT_LT((VoxelKey{-1, 0, 1}.Centre(2.0) - Eigen::Vector3d(-1.0, 1.0, 3.0)).norm(), 1e-12);
}

TEST(VoxelHash, AgreesWithAnOrderedMap) {
  Rng rng(1);
  VoxelHash<int> hash;
  std::map<std::tuple<int, int, int>, int> reference;
  for (int i = 0; i < 20000; ++i) {
    const VoxelKey key{static_cast<int32_t>(rng.Integer(40)) - 20,
                       static_cast<int32_t>(rng.Integer(40)) - 20,
                       static_cast<int32_t>(rng.Integer(20)) - 10};
    ++hash[key];
    ++reference[{key.x, key.y, key.z}];
  }
  EXPECT_EQ(hash.size(), reference.size());
  for (const auto& [key, count] : reference) {
    const int* found = hash.Find({std::get<0>(key), std::get<1>(key), std::get<2>(key)});
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(*found, count);
  }
  EXPECT_EQ(hash.Find({99, 0, 0}), nullptr);
}

}  // namespace
}  // namespace tvl
