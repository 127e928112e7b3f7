#include "tvl/io/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& yaml) {
  try {
    ParseRig(yaml, "rig.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Rig, WhatIsWrittenIsReadBack) {
  Rig rig;
  rig.lidar = LidarModel();
  rig.lidar->name = "four beams";
  for (const double deg : {3.0, 1.0 / 3.0, -4.0, -9.1}) {
    rig.lidar->beam_elevation_rad.push_back(DegToRad(deg));
  }
  rig.lidar->rows_are_beams = false;
  rig.lidar->max_range_m = 77.7;
  rig.camera = Camera{500.25, 501.5, 320.0, 240.125, 640, 480, {0.1, -0.2, 0.3, -0.4}};
  rig.camera->distortion_model = DistortionModel::kEquidistant;
  Vector6d xi;
  xi << 1.2, -1.2, 1.3, 0.1, -0.2, 0.3;
  rig.T_cam_lidar = Rigid3d::Exp(xi);
  rig.image_topic = "/camera/image";
  const Rig read = ParseRig(DumpRig(rig), "rig.yaml");
  EXPECT_EQ(read.lidar->name, "four beams");
  ASSERT_EQ(read.lidar->rows(), 4);
  EXPECT_NEAR(read.lidar->beam_elevation_rad[1], rig.lidar->beam_elevation_rad[1], 1e-15);
  EXPECT_FALSE(read.lidar->rows_are_beams);
  EXPECT_EQ(read.lidar->max_range_m, 77.7);
  EXPECT_EQ(read.camera->cy_px, 240.125);
  EXPECT_EQ(read.camera->width_px, 640);
  EXPECT_EQ(read.camera->distortion_model, DistortionModel::kEquidistant);
  EXPECT_EQ(read.camera->distortion, rig.camera->distortion);
  EXPECT_LT((read.T_cam_lidar->Inverse() * *rig.T_cam_lidar).Log().norm(), 1e-12);
  EXPECT_EQ(read.image_topic, "/camera/image");
  EXPECT_EQ(read.lidar_topic, "");
}

TEST(Rig, MayBeAProfileAlone) {
  const Rig rig = ParseRig("lidar:\n  name: mine\n  beam_elevation_deg: [1, 0, -1]\n", "rig.yaml");
  EXPECT_EQ(rig.lidar->rows(), 3);
  EXPECT_FALSE(rig.camera);
}

TEST(Rig, ErrorsNameFileLineAndKey) {
  EXPECT_THAT(ErrorOf("lidr: {}\n"), HasSubstr("rig.yaml:1: lidr: unknown key"));
  EXPECT_THAT(ErrorOf("camera:\n  size_px: [640, 480]\n"), HasSubstr("intrinsics_px"));
  EXPECT_THAT(ErrorOf("camera:\n  intrinsics_px: [1, 2, 3]\n"),
              HasSubstr("rig.yaml:2: camera.intrinsics_px: want 4 numbers, has 3"));
  EXPECT_THAT(ErrorOf("camera:\n  intrinsics_px: [1, 1, 0, 0]\n  distortion: [1, 2]\n"),
              HasSubstr("rig.yaml:3: camera.distortion: want 5 numbers"));
  EXPECT_THAT(ErrorOf("camera:\n  intrinsics_px: [1, 1, 0, 0]\n  distortion_model: odd\n"),
              HasSubstr("want plumb_bob, rational or equidistant, is 'odd'"));
  EXPECT_THAT(ErrorOf("T_cam_lidar: [1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0]\n"),
              HasSubstr("rig.yaml:1: T_cam_lidar"));
  EXPECT_THAT(ErrorOf("T_cam_lidar: [a\n"), HasSubstr("rig.yaml"));
  EXPECT_THAT(ErrorOf("- 1\n"), HasSubstr("a rig is a map"));
}

}  // namespace
}  // namespace tvl
