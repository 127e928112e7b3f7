#include "tvl/mapping/scan_to_map.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tvl/base/check.h"
#include "tvl/geometry/point_index.h"
#include "tvl/geometry/rigid3_matchers.h"
#include "tvl/optim/pose_solver.h"
#include "tvl/registration/test_world.h"

namespace tvl {
namespace {

using synthetic::Twist;
using synthetic::World;

const Calibration kCalibration = synthetic::CameraAndLidar();

std::shared_ptr<KeyframeCloud> CloudAt(const World& world, const Rigid3d& T, uint64_t seed) {
  const LaserFeatures features =
      synthetic::SampleFeatures(world, synthetic::Standing(T), Deskew::kNone, {0.02, seed});
  auto cloud = std::make_shared<KeyframeCloud>();
  cloud->planes.points = synthetic::PointsOf(features.less_flat);
  cloud->edges.points = synthetic::PointsOf(features.less_sharp);
  return cloud;
}

// Keyframes every metre along x up to 10 m, the whole world moved by `shift`.
std::vector<LocalMapMember> DriveThrough(const World& world, const Rigid3d& shift) {
  std::vector<LocalMapMember> keyframes;
  for (int k = 0; k <= 10; ++k) {
    const Rigid3d T = Rigid3d::Exp(Twist(0.0, 0.0, 0.01 * k, 1.0 * k, 0.0, 0.0));
    LocalMapMember keyframe;
    keyframe.path_m = k;
    keyframe.T_odom_lidar = shift * T;
    keyframe.cloud = CloudAt(world, T, 100 + static_cast<uint64_t>(k));
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

LocalMap MapOf(const std::vector<LocalMapMember>& keyframes) {
  LocalMap map{LocalMapOptions()};
  for (const LocalMapMember& keyframe : keyframes) map.Add(keyframe, Executor(1));
  return map;
}

LandmarkMap NoLandmarks() { return {synthetic::CameraAndLidar(), LandmarkOptions()}; }

PosePrior Prior(const Rigid3d& T, double sigma_rad, double sigma_m) {
  PosePrior prior;
  prior.T_world_lidar = T;
  prior.covariance.setZero();
  prior.covariance.diagonal().head<3>().setConstant(sigma_rad * sigma_rad);
  prior.covariance.diagonal().tail<3>().setConstant(sigma_m * sigma_m);
  prior.step_m = 1.0;
  return prior;
}

ScanToMapResult Refine(const KeyframeCloud& cloud, const LocalMap& map, const PosePrior& prior) {
  const ScanToMapOptions options;
  const MapStepPoints points =
      ThinForMapStep(cloud.planes.points, cloud.edges.points, options.source_voxel_m);
  return RefinePose(points, map, NoLandmarks(), {}, kCalibration, prior, options, Executor(1));
}

// The frame the map is asked about, and how wrong the prior is (right perturbation).
const Rigid3d kTruth = Rigid3d::Exp(Twist(0.01, -0.01, 0.08, 9.4, 0.3, 0.05));
const Rigid3d kPriorError = Rigid3d::Exp(Twist(0.004, -0.005, 0.012, 0.20, -0.10, 0.06));

class RefinePoseIn : public ::testing::TestWithParam<Rigid3d> {};

TEST_P(RefinePoseIn, FindsTheTruePoseFromAPerturbedPrior) {
  const World street = synthetic::Street();
  const Rigid3d shift = GetParam();
  const LocalMap map = MapOf(DriveThrough(street, shift));
  const auto cloud = CloudAt(street, kTruth, 5);
  for (const Rigid3d& error : {kPriorError, kPriorError.Inverse()}) {
    const ScanToMapResult result = Refine(*cloud, map, Prior(shift * kTruth * error, 0.05, 0.5));
    EXPECT_THAT(result.estimate.T_ref_body, Rigid3dNear(shift * kTruth, 0.001, 0.012));
    EXPECT_EQ(result.estimate.status, EstimateStatus::kConverged);
    EXPECT_TRUE(result.estimate.weak.empty());
    EXPECT_GT(result.estimate.evidence.planes, 500);
    EXPECT_GT(result.estimate.evidence.edges, 30);
    EXPECT_LT(result.estimate.evidence.plane_rms_m, 0.06);
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, RefinePoseIn,
                         ::testing::Values(Rigid3d(),  // as built; turned about; far off
                                           Rigid3d::Exp(Twist(0, 0, 3.1, 0, 0, 0)),
                                           Rigid3d::Exp(Twist(0.1, -0.2, 1.3, 2000, -900, 60))));

// The paper's Eq. (9)-(11) to the letter: the surrounding map is the union of the keyframes'
// points, each feature is matched with the plane through its five nearest neighbours.
class LiteralMap {
 public:
  explicit LiteralMap(const std::vector<LocalMapMember>& keyframes) {
    std::vector<Eigen::Vector3f> all;
    for (const LocalMapMember& keyframe : keyframes) {
      for (const auto& p : keyframe.cloud->planes.points) {
        all.push_back((keyframe.T_odom_lidar * p.cast<double>()).cast<float>());
      }
    }
    index_ = PointIndex(std::move(all));
  }

  Rigid3d Refine(const std::vector<Eigen::Vector3f>& points, Rigid3d T) const {
    for (int i = 0; i < 8; ++i) {
      const LaserMatches matches = Match(points, T);
      PoseSolverOptions options;
      T = SolvePose(
              T,
              [&](const Rigid3d& at) {
                return Linearize(matches, at, SweepBins::Compensated(), 2.0, Executor(1)).normal;
              },
              options)
              .T;
    }
    return T;
  }

 private:
  LaserMatches Match(const std::vector<Eigen::Vector3f>& points, const Rigid3d& T) const {
    LaserMatches matches;
    for (const auto& point : points) {
      const Eigen::Vector3d p_body = point.cast<double>();
      Neighbour neighbours[5];
      if (index_.Nearest((T * p_body).cast<float>(), 5, neighbours) < 5) continue;
      if (neighbours[4].distance_sq_m2 > 1.0f) continue;
      Eigen::Matrix<double, 3, 5> x;
      for (int n = 0; n < 5; ++n) x.col(n) = index_.points()[neighbours[n].index].cast<double>();
      const Eigen::Vector3d mean = x.rowwise().mean();
      x.colwise() -= mean;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(x * x.transpose() / 5.0);
      if (eigen.eigenvalues()[1] < 4.0 * eigen.eigenvalues()[0]) continue;
      const double variance = eigen.eigenvalues()[0] + 0.03 * 0.03;
      matches.planes.push_back({{p_body, eigen.eigenvectors().col(0), mean}, 1.0 / variance, 0});
    }
    return matches;
  }
  PointIndex index_;
};

TEST(RefinePose, AgreesWithEquations9To11) {
  const World street = synthetic::Street();
  const std::vector<LocalMapMember> keyframes = DriveThrough(street, Rigid3d());
  const auto cloud = CloudAt(street, kTruth, 6);
  const Rigid3d T_prior = kTruth * kPriorError;
  const Rigid3d T = Refine(*cloud, MapOf(keyframes), Prior(T_prior, 1.0, 10.0)).estimate.T_ref_body;
  const auto source = ThinForMapStep(cloud->planes.points, {}, 0.5).planes;
  const Rigid3d T_literal = LiteralMap(keyframes).Refine(source, T_prior);
  EXPECT_THAT(T_literal, Rigid3dNear(kTruth, 0.001, 0.015));
  EXPECT_THAT(T, Rigid3dNear(T_literal, 0.001, 0.015));
}

TEST(RefinePose, APriorThatIsSureOfItselfCounts) {
  const World street = synthetic::Street();
  const LocalMap map = MapOf(DriveThrough(street, Rigid3d()));
  const auto cloud = CloudAt(street, kTruth, 5);
  const Rigid3d T_prior = kTruth * Rigid3d::Translation(0.05, 0.05, 0.0);
  const auto distance_m = [&](double sigma_m) {
    const ScanToMapResult result = Refine(*cloud, map, Prior(T_prior, 0.1 * sigma_m, sigma_m));
    return (result.estimate.T_ref_body.t() - T_prior.t()).norm();
  };
  EXPECT_LT(distance_m(1e-5), 0.01);
  EXPECT_GT(distance_m(1.0), 0.06);
}

TEST(RefinePose, IsTheSameToTheBitForAnyThreadCount) {
  const World street = synthetic::Street();
  const LocalMap map = MapOf(DriveThrough(street, Rigid3d()));
  const auto cloud = CloudAt(street, kTruth, 5);
  const ScanToMapOptions options;
  const MapStepPoints points = ThinForMapStep(cloud->planes.points, cloud->edges.points, 0.3);
  const auto refine = [&](int threads) {
    return RefinePose(points, map, NoLandmarks(), {}, kCalibration,
                      Prior(kTruth * kPriorError, 0.05, 0.5), options, Executor(threads))
        .estimate.T_ref_body.Log();
  };
  EXPECT_EQ(refine(1), refine(2));
}

TEST(RefinePose, TooFewMatchesLeaveThePrediction) {
  const World street = synthetic::Street();
  const LocalMap map = MapOf(DriveThrough(street, Rigid3d()));
  KeyframeCloud few;
  few.planes.points = {{5, 0, -1.7f}, {6, 1, -1.7f}};
  const PosePrior prior = Prior(kTruth, 0.01, 0.1);
  const ScanToMapResult result = Refine(few, map, prior);
  EXPECT_EQ(result.estimate.status, EstimateStatus::kPredicted);
  EXPECT_THAT(result.estimate.T_ref_body, Rigid3dNear(kTruth, 1e-12, 1e-12));
  EXPECT_EQ(result.estimate.covariance, prior.covariance);
}

// In a tunnel, at 10 m along it, the prior being 0.2 m too far.
struct InTunnel {
  Rigid3d T_true = Rigid3d::Translation(9.8, 0.1, 0.0);
  Rigid3d T_prior = Rigid3d::Translation(0.2, 0.0, 0.0) * T_true;
  LocalMap map{LocalMapOptions()};
  LandmarkMap landmarks = NoLandmarks();
  FeatureTracks tracks;
  std::shared_ptr<KeyframeCloud> cloud;

  InTunnel() {
    const World tunnel = synthetic::Tunnel();
    map = MapOf(DriveThrough(tunnel, Rigid3d()));
    const auto corners = synthetic::Corners(tunnel, Rigid3d::Translation(9, 0, 0), 120, 3);
    const Rigid3d T_anchor = Rigid3d::Translation(9.0, 0.0, 0.0);
    const synthetic::Seen before = synthetic::Observe(corners, T_anchor, {0.3, 0.005, 1, 1});
    landmarks.Update(before.tracks, before.depths, T_anchor);
    tracks = synthetic::Observe(corners, T_true, {0.3, 0.005, 1, 2}).tracks;
    cloud = CloudAt(tunnel, T_true, 8);
  }
  ScanToMapResult Refine(bool use_camera) const {
    ScanToMapOptions options;
    options.use_camera = use_camera;
    const MapStepPoints points =
        ThinForMapStep(cloud->planes.points, cloud->edges.points, options.source_voxel_m);
    return RefinePose(points, map, landmarks, tracks, kCalibration, Prior(T_prior, 0.01, 0.3),
                      options, Executor(1));
  }
};

void ExpectWeakAlongX(const ScanToMapResult& result) {
  ASSERT_EQ(result.estimate.weak.size(), 1u);
  EXPECT_FALSE(result.estimate.weak[0].is_rotation);
  EXPECT_GT(std::abs(result.estimate.weak[0].axis_lidar.x()), std::cos(DegToRad(15.0)));
}

TEST(RefinePoseInATunnel, TheCameraHoldsTheAxis) {
  const InTunnel world;
  const ScanToMapResult result = world.Refine(true);
  EXPECT_GT(result.estimate.evidence.visual, 50);
  EXPECT_THAT(result.estimate.T_ref_body, Rigid3dNear(world.T_true, 0.001, 0.025));
  ExpectWeakAlongX(result);
  EXPECT_GT(result.estimate.weak[0].camera_strength, 0.0);
}

TEST(RefinePoseInATunnel, WithoutTheCameraThePriorHoldsTheAxis) {
  const InTunnel world;
  const ScanToMapResult result = world.Refine(false);
  EXPECT_EQ(result.estimate.evidence.visual, 0);
  ExpectWeakAlongX(result);
  const Eigen::Vector3d t = result.estimate.T_ref_body.t();
  EXPECT_NEAR(t.x(), world.T_prior.t().x(), 0.02);  // nothing pulls it
  EXPECT_NEAR(t.y(), world.T_true.t().y(), 0.01);   // the walls do
  EXPECT_NEAR(t.z(), world.T_true.t().z(), 0.01);
  // ... and it knows that it does not know.
  const Matrix6d covariance = result.estimate.covariance;
  EXPECT_GT(covariance(3, 3), 100.0 * covariance(4, 4));
  EXPECT_GT(std::sqrt(covariance(3, 3)), 0.29);  // all of the prior, 0.3 m: normals add nothing
}

TEST(ThinForMapStep, KeepsTheMiddlePointOfEachVoxel) {
  const std::vector<Eigen::Vector3f> points = {
      {0.1f, 0.1f, 0.1f}, {0.2f, 0.2f, 0.2f}, {0.7f, 0.1f, 0.1f}, {0.12f, 0.1f, 0.1f}};
  const MapStepPoints thin = ThinForMapStep(points, points, 0.5);
  ASSERT_EQ(thin.planes.size(), 2u);
  EXPECT_EQ(thin.planes[0], points[1]);
  EXPECT_EQ(thin.planes[1], points[2]);
  EXPECT_EQ(thin.plane_index, (std::vector<uint32_t>{1, 2}));
}

TEST(ScanToMapOptions, NameTheBadField) {
  ScanToMapOptions options;
  options.last_gate_m = 2.0 * options.first_gate_m;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
