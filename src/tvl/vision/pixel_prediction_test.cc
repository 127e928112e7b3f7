#include "tvl/vision/pixel_prediction.h"

#include <gtest/gtest.h>

namespace tvl {
namespace {

TEST(PixelPrediction, ProjectsIntoTheMovedCamera) {
  Camera camera;
  camera.fx_px = camera.fy_px = 500.0;
  camera.cx_px = 320.0;
  camera.cy_px = 240.0;
  FeatureTracks tracks;
  tracks.tracks.resize(3);
  tracks.tracks[0].id = 4;
  tracks.tracks[0].ray_cam = {0.2, -0.1};
  tracks.tracks[1].id = 7;  // no depth
  tracks.tracks[1].ray_cam = {0.0, 0.0};
  tracks.tracks[2].id = 9;  // passes the camera
  tracks.tracks[2].ray_cam = {0.5, 0.0};
  const VisualDepths depths = {{DepthStatus::kOk, 10.0, 0.1},
                               {DepthStatus::kNoPoints, 0.0, 0.0},
                               {DepthStatus::kOk, 2.0, 0.1}};
  const Rigid3d T_cur_prev = Rigid3d::Translation(0.0, 0.0, -2.0);  // 2 m forward
  const std::vector<PixelPrediction> predictions =
      PredictPixels(tracks, depths, T_cur_prev, camera).pixels;
  ASSERT_EQ(predictions.size(), 1u);
  EXPECT_EQ(predictions[0].id, 4);
  // (2, -1, 10) m seen 2 m nearer.
  EXPECT_NEAR(predictions[0].px_cam.x(), 500.0 * 2.0 / 8.0 + 320.0, 1e-9);
  EXPECT_NEAR(predictions[0].px_cam.y(), 500.0 * -1.0 / 8.0 + 240.0, 1e-9);
}

}  // namespace
}  // namespace tvl
