#include "tvl/odometry/carried_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

Eigen::Vector3f Polar(double azimuth_rad, double distance_m, double z_m) {
  return Eigen::Vector3d(distance_m * std::cos(azimuth_rad), distance_m * std::sin(azimuth_rad),
                         z_m)
      .cast<float>();
}

struct CloudData {
  std::vector<Eigen::Vector3f> points;
  std::vector<LaserFeature> features;

  void Add(const Eigen::Vector3f& p, uint16_t ring) {
    LaserFeature feature;
    feature.p_lidar = p;
    feature.ring = ring;
    points.push_back(p);
    features.push_back(feature);
  }
  RingCloud Build() const { return RingCloud(points, features); }
};

CloudData RandomRings(uint64_t seed, int rings, int count) {
  Rng rng(seed);
  CloudData data;
  for (int i = 0; i < count; ++i) {
    data.Add(Polar(rng.Uniform(-kPi, kPi), rng.Uniform(3, 12), rng.Uniform(-2, 3)),
             static_cast<uint16_t>(rng.Integer(rings)));
  }
  return data;
}

std::vector<uint32_t> BruteForce(const CloudData& data, int ring, const Eigen::Vector3f& p,
                                 size_t count, float max_distance_m) {
  std::vector<std::pair<double, uint32_t>> members;
  for (uint32_t i = 0; i < data.points.size(); ++i) {
    if (data.features[i].ring != ring) continue;
    const Eigen::Vector3f& q = data.points[i];
    const double d = std::abs(std::remainder(
        static_cast<double>(std::atan2(q.y(), q.x())) - std::atan2(p.y(), p.x()), 2.0 * kPi));
    members.emplace_back(d, i);
  }
  std::sort(members.begin(), members.end());
  if (members.size() > count) members.resize(count);
  std::vector<uint32_t> near;
  for (const auto& [gap, i] : members) {
    if ((data.points[i] - p).norm() <= max_distance_m) near.push_back(i);
  }
  return near;
}

TEST(RingCloud, NearestInRingAgreesWithBruteForce) {
  const CloudData data = RandomRings(1, 6, 700);
  const RingCloud cloud = data.Build();
  Rng rng(2);
  size_t found = 0;
  for (int i = 0; i < 500; ++i) {
    // Every fifth query next to the wrap at +-pi.
    const double azimuth = i % 5 == 0 ? kPi + rng.Uniform(-0.03, 0.03) : rng.Uniform(-kPi, kPi);
    const Eigen::Vector3f p = Polar(azimuth, rng.Uniform(3, 12), rng.Uniform(-2, 3));
    const int ring = static_cast<int>(rng.Integer(6)), count = 1 + static_cast<int>(rng.Integer(5));
    std::vector<uint32_t> actual;
    cloud.NearestInRing(ring, p, count, 4.0f, &actual);
    std::vector<uint32_t> expected = BruteForce(data, ring, p, static_cast<size_t>(count), 4.0f);
    std::sort(actual.begin(), actual.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(actual, expected);
    found += actual.size();
  }
  EXPECT_GT(found, 300u);
}

TEST(RingCloud, NearestInRingLooksAcrossTheBack) {
  CloudData data;
  data.Add(Polar(kPi - 0.01, 5.0, 0.0), 0);   // left of the seam
  data.Add(Polar(-kPi + 0.02, 5.0, 0.0), 0);  // right of it
  data.Add(Polar(0.5, 5.0, 0.0), 0);
  std::vector<uint32_t> found;
  data.Build().NearestInRing(0, Polar(-kPi + 0.001, 5.0, 0.0), 2, 1.0f, &found);
  EXPECT_EQ(found, (std::vector<uint32_t>{0, 1}));
}

TEST(RingCloud, RingsThatAreNotThereAreEmpty) {
  const RingCloud cloud = RandomRings(3, 2, 20).Build();
  std::vector<uint32_t> found;
  for (const int ring : {-1, 2, 500}) cloud.NearestInRing(ring, {1, 0, 0}, 3, 100.0f, &found);
  RingCloud().NearestInRing(0, {1, 0, 0}, 3, 100.0f, &found);
  EXPECT_TRUE(found.empty());
}

TEST(RingCloud, WantsOneFeatureAPoint) {
  CloudData data = RandomRings(4, 2, 5);
  data.points.pop_back();
  EXPECT_THROW(data.Build(), Error);
}

// A wall at y = 6, seen by rings a degree apart, every 10 cm.
CloudData Wall(int rings, double noise_m) {
  Rng rng(5);
  CloudData data;
  for (int ring = 0; ring < rings; ++ring) {
    for (int i = -20; i <= 20; ++i) {
      const double x = 0.1 * i, y = 6.0 + noise_m * rng.Normal();
      data.Add(Eigen::Vector3d(x, y, -std::hypot(x, y) * std::tan(DegToRad(ring))).cast<float>(),
               static_cast<uint16_t>(ring));
    }
  }
  return data;
}

TEST(FitPlaneAround, FindsTheWallOverSeveralRings) {
  const RingCloud cloud = Wall(4, 0.01).Build();
  const LocalFit fit = FitPlaneAround(cloud, 41 + 20);
  ASSERT_TRUE(fit.valid);
  EXPECT_GT(std::abs(fit.axis.y()), std::cos(0.15));
  EXPECT_NEAR(fit.mean.y(), 6.0, 0.02);
  EXPECT_LT(fit.variance_m2, 0.03 * 0.03);
}

TEST(FitPlaneAround, ASingleRingIsNoPlane) {
  EXPECT_FALSE(FitPlaneAround(Wall(1, 0.01).Build(), 20).valid);
  // Round a corner the points of a ring do lie on a plane: that of the beam.
  CloudData corner;
  for (int i = 0; i <= 10; ++i) {
    const float along = 0.1f * static_cast<float>(i);
    corner.Add({6.0f, 0.5f - along, -0.3f}, 4);
    corner.Add({6.0f + along, -0.5f, -0.3f}, 4);
  }
  const RingCloud cloud = corner.Build();
  for (uint32_t i = 0; i < cloud.size(); ++i) EXPECT_FALSE(FitPlaneAround(cloud, i).valid);
}

TEST(FitPlaneAround, ScatterIsNoPlane) {
  Rng rng(6);
  CloudData data;
  // Few a ring: many would give neighbours of nearly one azimuth, which lie on a plane by that.
  for (uint32_t i = 0; i < 18; ++i) {
    const Eigen::Vector3d p(6 + 0.35 * rng.Normal(), 0.35 * rng.Normal(), 0.35 * rng.Normal());
    data.Add(p.cast<float>(), static_cast<uint16_t>(i % 3));
  }
  uint32_t valid = 0;
  const RingCloud cloud = data.Build();
  for (uint32_t i = 0; i < cloud.size(); ++i) valid += FitPlaneAround(cloud, i).valid ? 1 : 0;
  EXPECT_LT(valid, 5u);
}

TEST(FitLineAround, FindsAPostAndRefusesOneRing) {
  CloudData post;
  for (uint16_t ring = 0; ring < 5; ++ring) post.Add({7.0f, 1.0f, 0.4f - 0.2f * ring}, ring);
  const LocalFit fit = FitLineAround(post.Build(), 2);
  ASSERT_TRUE(fit.valid);
  EXPECT_GT(std::abs(fit.axis.z()), 0.999);
  EXPECT_LT((fit.mean.head<2>() - Eigen::Vector2d(7, 1)).norm(), 1e-5);
  CloudData alone;
  for (int i = 0; i < 5; ++i) alone.Add({7.0f, 0.2f * static_cast<float>(i), 0.0f}, 3);
  EXPECT_FALSE(FitLineAround(alone.Build(), 2).valid);
}

TEST(FitLineAround, ARingTooFarOffIsNoNeighbour) {
  CloudData data;
  data.Add({7.0f, 1.0f, 0.4f}, 0);
  data.Add({7.0f, 1.0f, 0.2f}, 9);
  EXPECT_FALSE(FitLineAround(data.Build(), 0).valid);
}

}  // namespace
}  // namespace tvl
