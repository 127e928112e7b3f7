#include "tvl/registration/laser_terms.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/registration/beam_directions.h"

namespace tvl {
namespace {

constexpr int kBeams = 12;
constexpr double kHeight_m = 1.7;

// A road seen by beams that meet it 5 to 38 m away, `counts[k]` points of beam k, whose elevation
// is off by `errors_rad[k]`, and walls on both sides.
LaserMatches Road(const std::vector<int>& counts, const std::vector<double>& errors_rad) {
  Rng rng(7);
  LaserMatches matches;
  for (int beam = 0; beam < kBeams; ++beam) {
    for (int i = 0; i < counts[static_cast<size_t>(beam)]; ++i) {
      const double azimuth = rng.Uniform(-0.6, 0.6);  // ahead
      const double range_m = 5.0 + 3.0 * beam;
      const Eigen::Vector3d p(range_m * std::cos(azimuth), range_m * std::sin(azimuth), -kHeight_m);
      PlaneMatch match;
      match.factor.p_body = p + errors_rad[static_cast<size_t>(beam)] * DirectionsAt(p).elevation +
                            Eigen::Vector3d(0.0, 0.0, 0.01 * rng.Normal());
      match.factor.n_ref = Eigen::Vector3d::UnitZ();
      match.factor.q_ref = p;
      match.information = 1.0 / (0.03 * 0.03);
      match.beam = beam;
      matches.planes.push_back(match);
    }
  }
  for (int i = 0; i < 400; ++i) {
    PlaneMatch match;
    const int axis = i % 2;
    match.factor.p_body = {rng.Uniform(-20, 20), rng.Uniform(-20, 20), rng.Uniform(-1, 3)};
    match.factor.p_body[axis] = i % 4 < 2 ? 8.0 : -8.0;
    match.factor.n_ref = Eigen::Vector3d::Unit(axis);
    match.factor.q_ref = match.factor.p_body;
    match.information = 1.0 / (0.03 * 0.03);
    matches.planes.push_back(match);
  }
  return matches;
}

LaserSum At(const LaserMatches& matches, const Rigid3d& T) {
  const Executor executor(2);
  return Linearize(matches, T, SweepBins::Compensated(), 1e3, executor);
}

TEST(BeamErrors, EliminatedAreAsIfSolvedFor) {
  constexpr double kSigma_rad = 0.002;
  const LaserMatches matches =
      Road(std::vector<int>(kBeams, 40), std::vector<double>(kBeams, 0.001));
  const Rigid3d T =
      Rigid3d::Exp((Vector6d() << 0.001, -0.002, 0.003, 0.01, 0.02, -0.03).finished());
  const LaserSum sum = At(matches, T);
  ASSERT_EQ(sum.beams.size(), static_cast<size_t>(kBeams));
  // Pose and beams in one system, point by point.
  constexpr int kAll = 6 + kBeams;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kAll, kAll);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(kAll);
  for (const PlaneMatch& match : matches.planes) {
    const Residual<1> residual = Evaluate(match.factor, T.R(), T.t());
    Eigen::RowVectorXd J = Eigen::RowVectorXd::Zero(kAll);
    J.head<6>() = residual.J;
    if (match.beam >= 0) {
      // By differences: the residual with the beam turned up.
      PointToPlane turned = match.factor;
      turned.p_body += 1e-6 * DirectionsAt(match.factor.p_body).elevation;
      J[6 + match.beam] = (Evaluate(turned, T.R(), T.t()).r[0] - residual.r[0]) / 1e-6;
    }
    const double weight = match.information * 1.0;
    H += weight * J.transpose() * J;
    b += weight * J.transpose() * residual.r[0];
  }
  for (int beam = 0; beam < kBeams; ++beam) H(6 + beam, 6 + beam) += std::pow(kSigma_rad, -2);
  const Vector6d expected = H.ldlt().solve(b).head<6>();
  const NormalEquations rest = WithBeamErrors(sum, kSigma_rad);
  const Vector6d step = rest.H.ldlt().solve(rest.b);
  EXPECT_LT((step - expected).norm(), 1e-3 * expected.norm());
  const Matrix6d covariance = H.inverse().topLeftCorner<6, 6>();
  EXPECT_LT((rest.H.inverse() - covariance).norm(), 1e-3 * covariance.norm());
  EXPECT_LT(rest.cost, sum.normal.cost);
  // Beams that are known take nothing away.
  EXPECT_EQ(WithBeamErrors(sum, 0.0).H, sum.normal.H);
}

TEST(BeamErrors, ManyPointsOfABeamAreOneWitness) {
  std::vector<int> counts(kBeams, 20);
  std::vector<double> errors_rad(kBeams, 0.0);
  counts[8] = 600, errors_rad[8] = 0.003;  // one loud beam is off by 0.17 deg
  const LaserSum sum = At(Road(counts, errors_rad), Rigid3d());
  const auto pitch_rad = [](const NormalEquations& n) {
    return std::abs(n.H.ldlt().solve(n.b)[1]);
  };
  EXPECT_GT(pitch_rad(sum.normal), 1e-3);
  EXPECT_LT(pitch_rad(WithBeamErrors(sum, 0.002)), 0.25 * pitch_rad(sum.normal));
  // And the pitch is known no better than so many beams can tell, however many points feign.
  const auto sigma_rad = [](const NormalEquations& n) {
    return std::sqrt(Matrix6d(n.H.inverse())(1, 1));
  };
  const double expected_rad = 0.002 / std::sqrt(static_cast<double>(kBeams));
  EXPECT_LT(sigma_rad(sum.normal), 0.5 * expected_rad);
  EXPECT_NEAR(sigma_rad(WithBeamErrors(sum, 0.002)), expected_rad, 0.3 * expected_rad);
}

}  // namespace
}  // namespace tvl
