#include "tvl/registration/surfel.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

using Points = std::vector<Eigen::Vector3d>;

PointMoments MomentsOf(const Points& points) {
  PointMoments moments;
  for (const Eigen::Vector3d& p : points) moments.Add(p, 1);
  return moments;
}

bool Same(const PointMoments& a, const PointMoments& b) {
  return a.count == b.count && std::equal(a.sum, a.sum + 3, b.sum) &&
         std::equal(a.square, a.square + 6, b.square);
}

// A disc of the given normal through q, scattered by sigma_m across.
Points Disc(Rng& rng, const Eigen::Vector3d& normal, const Eigen::Vector3d& q, double sigma_m,
            int count) {
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  Points points;
  while (points.size() < static_cast<size_t>(count)) {
    const double a = rng.Uniform(-0.4, 0.4), b = rng.Uniform(-0.4, 0.4);
    points.push_back(q + a * u + b * v + sigma_m * rng.Normal() * normal);
  }
  return points;
}

Points Blob(Rng& rng, double sigma_m, int count) {
  Points points;
  for (int i = 0; i < count; ++i) {
    points.push_back(sigma_m * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
  }
  return points;
}

struct Reference {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

Reference BruteForce(const Points& points) {
  Reference reference;
  const double n = static_cast<double>(points.size());
  for (const auto& p : points) reference.mean += p / n;
  for (const auto& p : points) {
    const Eigen::Vector3d d = p - reference.mean;
    reference.covariance += d * d.transpose() / n;
  }
  return reference;
}

TEST(PointMoments, AreTheSameInAnyOrderAndAfterTakingAway) {
  Rng rng(1);
  Points points = Blob(rng, 0.3, 200);
  const PointMoments forward = MomentsOf(points);
  std::reverse(points.begin(), points.end());
  PointMoments other = MomentsOf(points);
  EXPECT_TRUE(Same(forward, other));
  const Points guests = Blob(rng, 0.4, 77);
  for (const auto& p : guests) other.Add(p, 1);
  EXPECT_FALSE(Same(forward, other));
  for (auto p = guests.rbegin(); p != guests.rend(); ++p) other.Add(*p, -1);
  EXPECT_TRUE(Same(forward, other));
  for (const auto& p : points) other.Add(p, -1);
  EXPECT_TRUE(Same(other, PointMoments()));
}

TEST(PointMoments, MeanAndCovarianceAgreeWithDoubles) {
  Rng rng(2);
  const Points points =
      Disc(rng, Eigen::Vector3d(1, 2, 3).normalized(), {0.2, -0.1, 0.3}, 0.02, 50);
  const PointMoments moments = MomentsOf(points);
  const Reference reference = BruteForce(points);
  // Coordinates are rounded to 1/1024 m.
  EXPECT_LT((moments.MeanCentred_m() - reference.mean).norm(), 2e-4);
  EXPECT_LT((moments.Covariance_m2() - reference.covariance).norm(), 2e-4);
}

TEST(FitPlane, AgreesWithTheEigenvectorsOfDoubles) {
  Rng rng(3);
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, 1.0).normalized();
  const Eigen::Vector3d centre(10.5, -20.5, 1.5);
  const Points points = Disc(rng, normal, {0.05, 0.02, -0.1}, 0.03, 400);
  const Surfel surfel = FitPlane(MomentsOf(points), centre, 1.0, SurfelOptions());
  const Reference reference = BruteForce(points);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(reference.covariance);
  ASSERT_EQ(surfel.kind, SurfelKind::kPlane);
  EXPECT_LT((surfel.mean - centre - reference.mean).norm(), 1e-3);
  EXPECT_GT(std::abs(surfel.axis.dot(eigen.eigenvectors().col(0))), 1.0 - 1e-6);
  EXPECT_NEAR(surfel.thickness_sq_m2, eigen.eigenvalues()[0], 1e-5);
  EXPECT_NEAR(surfel.extent_sq_m2, eigen.eigenvalues()[1], 1e-3);
  EXPECT_EQ(surfel.count, 400.0);
  // 3 cm of noise, 400 points over 0.8 m: the normal is known to 0.4 degrees.
  EXPECT_GT(std::abs(surfel.axis.dot(normal)), std::cos(0.015));
}

TEST(FitLine, AgreesWithTheEigenvectorsOfDoubles) {
  Rng rng(4);
  Points points;
  for (int i = 0; i < 40; ++i) {
    points.push_back({0.01 * rng.Normal(), 0.02 * rng.Normal(), rng.Uniform(-0.5, 0.5)});
  }
  const Surfel surfel = FitLine(MomentsOf(points), Eigen::Vector3d::Zero(), 1.0, SurfelOptions());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(BruteForce(points).covariance);
  ASSERT_EQ(surfel.kind, SurfelKind::kLine);
  EXPECT_GT(std::abs(surfel.axis.z()), 0.999);
  EXPECT_NEAR(surfel.thickness_sq_m2, eigen.eigenvalues()[1], 1e-5);
  EXPECT_NEAR(surfel.extent_sq_m2, eigen.eigenvalues()[2], 1e-4);
}

TEST(FitPlane, RejectsWhatIsNoPlane) {
  Rng rng(5);
  const auto kind = [](const Points& points) {
    return FitPlane(MomentsOf(points), Eigen::Vector3d::Zero(), 1.0, SurfelOptions()).kind;
  };
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  EXPECT_EQ(kind(Disc(rng, up, Eigen::Vector3d::Zero(), 0.02, 40)), SurfelKind::kPlane);
  EXPECT_EQ(kind(Disc(rng, up, Eigen::Vector3d::Zero(), 0.02, 3)), SurfelKind::kNone);   // few
  EXPECT_EQ(kind(Disc(rng, up, Eigen::Vector3d::Zero(), 0.30, 90)), SurfelKind::kNone);  // thick
  EXPECT_EQ(kind(Blob(rng, 0.1, 100)), SurfelKind::kNone);
  EXPECT_EQ(FitPlane(PointMoments(), up, 1.0, SurfelOptions()).kind, SurfelKind::kNone);
}

TEST(FitPlane, RejectsTheArcOfASingleRing) {
  Rng rng(6);
  Points arc;  // of a ring of 8 m radius on the ground: long, and thin in two directions
  for (int i = 0; i < 60; ++i) {
    const double phi = rng.Uniform(-0.06, 0.06);
    arc.push_back({8.0 * (std::cos(phi) - 1.0) + 0.01 * rng.Normal(), 8.0 * std::sin(phi),
                   0.004 * rng.Normal()});
  }
  const PointMoments moments = MomentsOf(arc);
  const Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  EXPECT_EQ(FitPlane(moments, centre, 1.0, SurfelOptions()).kind, SurfelKind::kNone);
  for (auto& p : arc) p.x() += rng.Integer(2) == 0 ? -0.2 : 0.2;  // two rings: a plane
  EXPECT_EQ(FitPlane(MomentsOf(arc), centre, 1.0, SurfelOptions()).kind, SurfelKind::kPlane);
}

TEST(FitLine, RejectsPlanesBlobsAndStubs) {
  Rng rng(7);
  const auto kind = [](const Points& points) {
    return FitLine(MomentsOf(points), Eigen::Vector3d::Zero(), 1.0, SurfelOptions()).kind;
  };
  EXPECT_EQ(kind(Disc(rng, Eigen::Vector3d::UnitX(), Eigen::Vector3d::Zero(), 0.01, 60)),
            SurfelKind::kNone);
  EXPECT_EQ(kind(Blob(rng, 0.1, 60)), SurfelKind::kNone);
  Points stub;
  for (int i = 0; i < 30; ++i) stub.push_back({0.0, 0.005 * rng.Normal(), 0.05 * rng.Uniform()});
  EXPECT_EQ(kind(stub), SurfelKind::kNone);
}

TEST(SurfelOptions, NamesTheBadField) {
  SurfelOptions options;
  options.min_points = 2;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
