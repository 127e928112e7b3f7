#include "tvl/sim/camera_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl::sim {
namespace {

void AddQuad(Mesh& mesh, Material material, const Eigen::Vector3f& corner, const Eigen::Vector3f& a,
             const Eigen::Vector3f& b) {
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  for (const Eigen::Vector3f& v : {corner, Eigen::Vector3f(corner + a),
                                   Eigen::Vector3f(corner + a + b), Eigen::Vector3f(corner + b)}) {
    mesh.vertices.push_back(v);
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  mesh.materials.insert(mesh.materials.end(), 2, material);
}

SceneStructure Box(Material material, float x, float y, float z, float dx, float dy, float dz) {
  Mesh mesh;
  const Eigen::Vector3f ex(dx, 0, 0), ey(0, dy, 0), ez(0, 0, dz);
  const Eigen::Vector3f low(0.0F, 0.0F, 0.0F);
  for (const auto& side : {std::pair{ex, ez}, std::pair{ey, ez}, std::pair{ex, ey}}) {
    const Eigen::Vector3f third = ex + ey + ez - side.first - side.second;
    AddQuad(mesh, material, low, side.first, side.second);
    AddQuad(mesh, material, low + third, side.first, side.second);
  }
  return {mesh, Rigid3d::Translation(x, y, z)};
}

// A street along x between two rows of houses of different depth.
SceneDescription Street() {
  SceneDescription scene;
  Mesh ground;
  AddQuad(ground, Material::kAsphalt, {-50, -4, 0}, {200, 0, 0}, {0, 8, 0});
  AddQuad(ground, Material::kPavement, {-50, 4, 0}, {200, 0, 0}, {0, 30, 0});
  AddQuad(ground, Material::kGrass, {-50, -34, 0}, {200, 0, 0}, {0, 30, 0});
  scene.structures.push_back({ground, Rigid3d()});
  Rng rng(2);
  for (int i = 0; i < 14; ++i) {
    const auto x = static_cast<float>(i * 9 - 20);
    const auto left = static_cast<float>(rng.Uniform(5.5, 8.0));
    const auto right = static_cast<float>(rng.Uniform(5.5, 8.0));
    const auto height = static_cast<float>(rng.Uniform(4.0, 9.0));
    scene.structures.push_back(Box(Material::kPlaster, x, left, 0, 8, 8, height));
    scene.structures.push_back(Box(Material::kBrick, x, -right - 8, 0, 8, 8, height));
  }
  scene.structures.push_back(Box(Material::kCarPaint, 14, 2, 0, 4, 1.7F, 1.5F));
  return scene;
}

Camera SmallCamera() { return {360.0, 360.0, 310.0, 110.0, 620, 200, {}}; }

// The camera 1.65 m above the street, looking along +x.
Rigid3d Pose(double x, double y, double yaw_rad) {
  Eigen::Matrix3d R_world_cam;
  R_world_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Matrix3d yaw =
      Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return {Eigen::Matrix3d(yaw * R_world_cam), Eigen::Vector3d(x, y, 1.65)};
}

class CameraRendererTest : public ::testing::Test {
 protected:
  CameraRendererTest() : scene_(Street()), renderer_(scene_, SmallCamera()) {}

  cv::Mat Render(const Rigid3d& T_world_cam, uint64_t frame = 0) const {
    return renderer_.Render({T_world_cam, 0.0, frame, false}, Executor(2));
  }

  // What the pixel sees in the world; false: sky.
  bool PointAt(const Rigid3d& T_world_cam, const cv::Point2f& px, Eigen::Vector3d& p_world) const {
    const Eigen::Vector2d n = SmallCamera().Unproject({px.x, px.y});
    const Eigen::Vector3d direction = T_world_cam.q() * Eigen::Vector3d(n.x(), n.y(), 1.0);
    RayPacket rays;
    rays.Set(0, T_world_cam.t().cast<float>(), direction.normalized().cast<float>(), 200.0F);
    const SceneHit hit = scene_.View(0.0, 0.0).Intersect(rays)[0];
    p_world = hit.p_world.cast<double>();
    return hit.hit;
  }

  Scene scene_;
  CameraRenderer renderer_;
};

TEST_F(CameraRendererTest, LooksLikeAPicture) {
  const cv::Mat image = Render(Pose(0, 0, 0));
  ASSERT_EQ(image.type(), CV_8U);
  ASSERT_EQ(image.size(), cv::Size(620, 200));
  cv::Scalar mean, sigma;
  cv::meanStdDev(image, mean, sigma);
  EXPECT_GT(mean[0], 50.0);
  EXPECT_LT(mean[0], 140.0);
  EXPECT_GT(sigma[0], 30.0);
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(image, corners, 5000, 0.01, 8.0);
  EXPECT_GT(corners.size(), 200U);
}

TEST_F(CameraRendererTest, SameBytesForAnyNumberOfThreads) {
  const CameraShot shot{Pose(3, 0.5, 0.1), 0.0, 9, false};
  const cv::Mat one = renderer_.Render(shot, Executor(1));
  const cv::Mat three = renderer_.Render(shot, Executor(3));
  EXPECT_EQ(cv::norm(one, three, cv::NORM_INF), 0.0);
}

TEST_F(CameraRendererTest, NightIsAlmostBlack) {
  const cv::Mat image = renderer_.Render({Pose(0, 0, 0), 0.0, 0, true}, Executor(2));
  EXPECT_LT(cv::mean(image)[0], 5.0);
}

TEST_F(CameraRendererTest, HousesThrowShadows) {
  CameraRenderOptions options;
  options.sun_shadows = false;
  options.film.exposure_strength = 0.0;
  const CameraShot shot{Pose(0, 0, 0), 0.0, 0, false};
  const cv::Mat bare = CameraRenderer(scene_, SmallCamera(), options).Render(shot, Executor(2));
  options.sun_shadows = true;
  const cv::Mat lit = CameraRenderer(scene_, SmallCamera(), options).Render(shot, Executor(2));
  const int darker = cv::countNonZero(bare - lit > 30);
  EXPECT_GT(darker, 5000);
  EXPECT_EQ(cv::countNonZero(lit - bare > 30), 0);
}

TEST_F(CameraRendererTest, FurtherRaysSmoothOutlines) {
  CameraRenderOptions options;
  options.film.read_noise_grey = options.film.photon_noise_grey = 0.0;
  options.film.exposure_strength = 0.0;
  std::vector<cv::Mat> images;
  for (const int samples : {0, 2, 16}) {
    options.edge_samples = samples;
    images.push_back(CameraRenderer(scene_, SmallCamera(), options)
                         .Render({Pose(0, 0, 0.1), 0.0, 0, false}, Executor(2)));
  }
  const double bare = cv::norm(images[0], images[2], cv::NORM_L2);
  EXPECT_LT(cv::norm(images[1], images[2], cv::NORM_L2), 0.7 * bare);
}

// A dark box before the sky: its upright edge is where the camera model says.
TEST(CameraRenderer, EdgesAreWhereTheyProject) {
  SceneDescription description;
  description.structures.push_back(Box(Material::kTyre, 10, -5, -5, 1, 5.3F, 20));
  const Scene scene(description);
  CameraRenderOptions options;
  options.film.exposure_strength = 0.0;
  options.edge_samples = 8;
  options.lighting.sky = 0.6;  // over-exposed, it would bloom over the edge
  const Camera camera = SmallCamera();
  const CameraRenderer renderer(scene, camera, options);
  for (const double y : {0.0, 0.004, 0.008, 0.013, 0.02}) {  // 0.036 m is a pixel
    const Rigid3d T_world_cam = Pose(0, y, 0);
    const cv::Mat image = renderer.Render({T_world_cam, 0.0, 0, false}, Executor(1));
    const Eigen::Vector3d corner = T_world_cam.Inverse() * Eigen::Vector3d(10, 0.3, 1.65);
    const double expected = camera.Project(corner.hnormalized()).x();
    double dark = 0.0;  // share of the box around the edge, summed over columns
    const auto x0 = static_cast<int>(expected) - 6;
    const double sky = cv::mean(image.col(x0 - 10))[0];
    const double box = cv::mean(image.col(x0 + 20))[0];
    ASSERT_GT(sky, 4.0 * box);
    for (int x = x0; x < x0 + 13; ++x) dark += (sky - cv::mean(image.col(x))[0]) / (sky - box);
    EXPECT_NEAR(x0 + 12.5 - dark, expected, 0.15);
  }
}

// Points seen in one picture and projected into the next lie where tracking finds them.
TEST_F(CameraRendererTest, TexturesAreStuckToTheGeometry) {
  const Rigid3d T_world_a = Pose(0, 0, 0);
  const Rigid3d T_world_b = Pose(0.9, 0.1, 0.02);
  const cv::Mat a = Render(T_world_a, 0);
  const cv::Mat b = Render(T_world_b, 1);
  std::vector<cv::Point2f> corners, in_a, expected;
  cv::goodFeaturesToTrack(a, corners, 300, 0.01, 12.0);
  for (const cv::Point2f& px : corners) {
    Eigen::Vector3d p_world;
    if (!PointAt(T_world_a, px, p_world)) continue;
    const Eigen::Vector3d p_cam = T_world_b.Inverse() * p_world;
    const Eigen::Vector2d to = SmallCamera().Project(p_cam.hnormalized());
    if (to.x() < 12 || to.y() < 12 || to.x() > 607 || to.y() > 187) continue;
    in_a.push_back(px);
    expected.emplace_back(static_cast<float>(to.x()), static_cast<float>(to.y()));
  }
  ASSERT_GT(in_a.size(), 80U);
  std::vector<cv::Point2f> found = expected;
  std::vector<uchar> status;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(a, b, in_a, found, status, error, {15, 15}, 2,
                           {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01},
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<double> errors_px;
  for (size_t i = 0; i < found.size(); ++i) {
    errors_px.push_back(status[i] ? cv::norm(found[i] - expected[i]) : 10.0);
  }
  std::nth_element(errors_px.begin(), errors_px.begin() + errors_px.size() / 2, errors_px.end());
  EXPECT_LT(errors_px[errors_px.size() / 2], 0.3);
}

TEST_F(CameraRendererTest, RefusesACameraWithoutSize) {
  Camera camera = SmallCamera();
  camera.width_px = 0;
  EXPECT_THROW(CameraRenderer(scene_, camera), InputError);
}

}  // namespace
}  // namespace tvl::sim
