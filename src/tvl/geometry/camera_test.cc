#include "tvl/geometry/camera.h"

#include <gtest/gtest.h>

namespace tvl {
namespace {

Camera KittiLike() {
  Camera camera;
  camera.fx_px = camera.fy_px = 720.0;
  camera.cx_px = 610.0;
  camera.cy_px = 173.0;
  return camera;
}

TEST(Camera, ProjectsByHand) {
  const Eigen::Vector2d px = KittiLike().Project({0.5, -0.1});
  EXPECT_DOUBLE_EQ(px.x(), 970.0);
  EXPECT_DOUBLE_EQ(px.y(), 101.0);
}

TEST(Camera, UnprojectUndoesDistortion) {
  Camera camera = KittiLike();
  camera.distortion = {-0.37, 0.2, 0.0009, 0.0018, -0.07};
  for (const Eigen::Vector2d& n :
       {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.6, 0.2), Eigen::Vector2d(-0.7, -0.2)}) {
    EXPECT_LT((camera.Unproject(camera.Project(n)) - n).norm(), 1e-6);
  }
}

}  // namespace
}  // namespace tvl
