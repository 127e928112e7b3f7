#include "tvl/io/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using testing::Contains;
using testing::HasSubstr;

std::string ErrorOf(const std::string& yaml) {
  try {
    ParseProfile(yaml, "p.yaml");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Profile, KittiIsBuiltInWithItsTwoBlocks) {
  const LidarModel kitti = LoadProfile("kitti");
  ASSERT_EQ(kitti.rows(), 64);
  EXPECT_NEAR(RadToDeg(kitti.beam_elevation_rad[0]), 2.0, 1e-9);
  EXPECT_NEAR(RadToDeg(kitti.beam_elevation_rad[1]), 2.0 - 1.0 / 3.0, 1e-6);
  EXPECT_NEAR(RadToDeg(kitti.beam_elevation_rad[32]), -8.8333333, 1e-9);
  EXPECT_NEAR(RadToDeg(kitti.LargestGap_rad()), 0.5, 1e-6);
  EXPECT_NEAR(RadToDeg(kitti.vertical_correction_rad), 0.205, 1e-12);
  EXPECT_THAT(ProfileNames(), Contains("none"));
  EXPECT_EQ(LoadProfile("none").rows(), 0);
}

TEST(Profile, ReadsAUserFile) {
  const TempFolder folder;
  const std::string path = folder.Write(
      "mine.yaml", "lidar: {name: mine, beam_elevation_deg: [15, 0, -15], max_range_m: 50}");
  const LidarModel model = LoadProfile(path);
  EXPECT_EQ(model.name, "mine");
  ASSERT_EQ(model.rows(), 3);
  EXPECT_NEAR(model.beam_elevation_rad[2], DegToRad(-15.0), 1e-12);
  EXPECT_EQ(model.max_range_m, 50.0);
}

TEST(Profile, ErrorsNameFileLineAndKey) {
  EXPECT_THAT(ErrorOf("lidar:\n  name: x\n  colums: 3\n"),
              HasSubstr("p.yaml:3: lidar.colums: unknown key"));
  EXPECT_THAT(ErrorOf("lidar:\n  columns: many\n"), HasSubstr("p.yaml:2: lidar.columns"));
  EXPECT_THAT(ErrorOf("lidar: {}\ncamera: {}\n"), HasSubstr("p.yaml:2: camera: unknown key"));
  EXPECT_THAT(ErrorOf("lidar: {sweep_s: -1}"), HasSubstr("lidar.sweep_s"));
  EXPECT_THAT(ErrorOf("lidar: {beam_blocks_deg: [[1, 2]]}"), HasSubstr("beam_blocks_deg"));
  EXPECT_THAT(ErrorOf("lidar: ["), HasSubstr("p.yaml"));
  EXPECT_THAT(ErrorOf("3"), HasSubstr("p.yaml"));
  EXPECT_THROW(LoadProfile("no such profile"), InputError);
}

}  // namespace
}  // namespace tvl
