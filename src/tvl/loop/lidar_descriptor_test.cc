#include "tvl/loop/lidar_descriptor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/loop/lidar_descriptor_test_world.h"

namespace tvl {
namespace {

using synthetic::OnGround;
using synthetic::Scan;
using synthetic::Street;
using synthetic::Town;
using ::testing::HasSubstr;

TEST(DescribePlace, ShapesAndNorms) {
  const LidarDescriptor place = DescribePlace(Scan(Street(200.0, 1), OnGround(100, 0, 0), 1), {});
  EXPECT_GT(place.cells.size(), 200u);
  EXPECT_EQ(place.spectrum.size(), 32u * 64u);
  ASSERT_EQ(place.signature.size(), 32u * 12u);
  EXPECT_GT(place.energy, 0.0F);
  double norm_sq = 0.0;
  for (const float s : place.signature) norm_sq += s * s;
  EXPECT_NEAR(norm_sq, 1.0, 1e-4);
  for (size_t ring = 0; ring < 32; ++ring) {
    double sum = 0.0, ring_sq = 0.0;
    for (size_t a = 0; a < 64; ++a) {
      sum += place.spectrum[ring * 64 + a];
      ring_sq += place.spectrum[ring * 64 + a] * place.spectrum[ring * 64 + a];
    }
    EXPECT_NEAR(sum, 0.0, 20.0);
    EXPECT_NEAR(std::sqrt(ring_sq), 127.0, 4.0);
  }
}

// Turned by any yaw and in the other lane, a place is more like itself than like any other place of
// the street.
TEST(DescribePlace, TurnedAndShiftedPlaceBeatsOthers) {
  const Town town = Street(300.0, 2);
  std::vector<LidarDescriptor> places;
  for (int i = 0; i < 12; ++i) {
    places.push_back(DescribePlace(
        Scan(town, OnGround(40.0 + 20.0 * i, -1.5, 0.0), 10 + static_cast<uint64_t>(i)), {}));
  }
  for (int i = 0; i < 12; ++i) {
    for (int turn = 0; turn < 5; ++turn) {
      const Rigid3d T = OnGround(40.0 + 20.0 * i + 1.0, 2.0, 0.4 + 2.0 * kPi * turn / 5.0);
      const LidarDescriptor again =
          DescribePlace(Scan(town, T, 100 + static_cast<uint64_t>(i * 5 + turn)), {});
      for (int other = 0; other < 12; ++other) {
        if (other == i) continue;
        EXPECT_GT(SignatureSimilarity(again, places[static_cast<size_t>(i)]),
                  SignatureSimilarity(again, places[static_cast<size_t>(other)]))
            << "place " << i << " turn " << turn << " taken for " << other;
      }
    }
  }
}

TEST(DescribePlace, NothingThere) {
  const LidarDescriptor none = DescribePlace(KeyframeCloud{}, {});
  EXPECT_TRUE(none.cells.empty());
  EXPECT_EQ(none.energy, 0.0F);
  EXPECT_EQ(SignatureSimilarity(none, none), 0.0F);
  EXPECT_THROW(SignatureSimilarity(none, LidarDescriptor{}), Error);
}

TEST(DescribePlace, PointsThatAreNoNumbersAreLeftOut) {
  KeyframeCloud cloud = Scan(Street(200.0, 1), OnGround(100, 0, 0), 1);
  const LidarDescriptor clean = DescribePlace(cloud, {});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  cloud.planes.points.emplace_back(nan, 1.0F, 1.0F);
  cloud.planes.points.emplace_back(1.0F, 1.0F, nan);
  cloud.planes.points.emplace_back(1e30F, 1.0F, 1.0F);
  EXPECT_EQ(DescribePlace(cloud, {}).signature, clean.signature);
}

TEST(LidarDescriptorOptions, NamesTheField) {
  const auto message = [](double LidarDescriptorOptions::*field, double value) -> std::string {
    LidarDescriptorOptions options;
    options.*field = value;
    try {
      options.Check();
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message(&LidarDescriptorOptions::range_m, 40.0), "");
  EXPECT_EQ(LidarDescriptorOptions{}.grid(), 128);
  EXPECT_THAT(message(&LidarDescriptorOptions::range_m, 0.0), HasSubstr("range_m"));
  EXPECT_THAT(message(&LidarDescriptorOptions::cell_m, 0.0), HasSubstr("cell_m"));
  EXPECT_THAT(message(&LidarDescriptorOptions::cell_m, 30.0), HasSubstr("cell_m"));
  EXPECT_THAT(message(&LidarDescriptorOptions::min_height_m, -1.0), HasSubstr("min_height_m"));
  EXPECT_THAT(message(&LidarDescriptorOptions::max_height_m, 0.1), HasSubstr("max_height_m"));
  EXPECT_THAT(message(&LidarDescriptorOptions::ground_cell_m, 0.0), HasSubstr("ground_cell_m"));
  EXPECT_THAT(message(&LidarDescriptorOptions::ground_slope, 0.0), HasSubstr("ground_slope"));
  EXPECT_THAT(message(&LidarDescriptorOptions::min_wavelength_m, 1.0),
              HasSubstr("min_wavelength_m"));
  EXPECT_THAT(message(&LidarDescriptorOptions::max_wavelength_m, 99.0),
              HasSubstr("max_wavelength_m"));
}

}  // namespace
}  // namespace tvl
