#include "tvl/registration/edge_score.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace tvl {
namespace {

using Samples = EdgeProfile::Samples;

constexpr int kReach = EdgeProfile::kReach;
constexpr double kStep_rad = EdgeProfile::kStep_rad;

// A clear answer: its score stands out so many times the scatter of the scores elsewhere, where the
// best is lower by this factor.
constexpr double kMinContrast = 4.5;
constexpr double kMaxSecond = 0.55;
constexpr double kElsewhere_rad = 0.012;  // 0.7 deg from the best

constexpr int kSteps = 20;  // of a first search to either side: 1.5 deg
constexpr size_t kAxisSteps = 2 * kSteps + 1;

// Score and its derivatives by the position, in samples.
struct Sample {
  double value = 0.0, slope = 0.0, bend = 0.0;
};

// By a parabola through the three nearest samples: smooth enough between smoothed samples.
Sample At(const Samples& samples, double position) {
  const double s = position + kReach;
  const int i = static_cast<int>(std::lround(s));
  if (i < 1 || i + 1 >= static_cast<int>(samples.size())) return {};
  const double a = s - i;
  const auto at = [&](int k) { return static_cast<double>(samples[static_cast<size_t>(k)]); };
  const double slope = 0.5 * (at(i + 1) - at(i - 1)), bend = at(i + 1) - 2.0 * at(i) + at(i - 1);
  return {at(i) + a * (slope + 0.5 * a * bend), slope + a * bend, bend};
}

// Without what bends upwards: such directions are left to the prior.
EdgeMatrix NonNegative(const EdgeMatrix& symmetric) {
  const Eigen::SelfAdjointEigenSolver<EdgeMatrix> solver(symmetric);
  const EdgeVector kept = solver.eigenvalues().cwiseMax(0.0);
  return solver.eigenvectors() * kept.asDiagonal() * solver.eigenvectors().transpose();
}

// Of those along an axis, or of many such axes in a row, those far from the step `best` of the
// axis.
std::vector<double> Elsewhere(const std::vector<double>& scores, size_t best) {
  const int apart = static_cast<int>(kElsewhere_rad / kStep_rad);
  std::vector<double> elsewhere;
  for (size_t i = 0; i < scores.size(); ++i) {
    const int step = static_cast<int>(i % kAxisSteps);
    if (std::abs(step - static_cast<int>(best)) > apart) elsewhere.push_back(scores[i]);
  }
  return elsewhere;
}

bool StandsOut(double best, const std::vector<double>& elsewhere) {
  if (elsewhere.size() < 10) return false;
  double sum = 0.0, squares = 0.0, second = -1e300;
  for (const double score : elsewhere) {
    sum += score;
    squares += score * score;
    second = std::max(second, score);
  }
  const double count = static_cast<double>(elsewhere.size());
  const double mean = sum / count;
  const double sigma = std::sqrt(std::max(0.0, squares / count - mean * mean));
  const double height = best - mean;
  return height > kMinContrast * sigma && second - mean < kMaxSecond * height;
}

// The score's maximum is an M-estimate: its covariance is that of the gradients between the
// inverses of the curvature, with those of one thing taken together.
class FineSearch {
 public:
  FineSearch(const std::vector<PlacedEdge>& placed, const EdgePrior& prior, const EdgeVector& start)
      : placed_(placed), expected_(prior.expected), x_(start) {
    prior_ = prior.sigma.cwiseAbs2().cwiseInverse().asDiagonal();
    EdgeVector squares = EdgeVector::Zero();
    for (const PlacedEdge& p : placed) squares += (kStep_rad * p.edge->J.transpose()).cwiseAbs2();
    rad_a_unit_ = (squares / static_cast<double>(std::max<size_t>(1, placed.size()))).cwiseSqrt();
    rad_a_unit_.head<3>().setZero();
  }

  bool Solve() {
    constexpr int kIterations = 12;
    for (int i = 0; i < kIterations; ++i) {
      if (!Linearize()) return false;
      EdgeVector step = H_.ldlt().solve(b_);
      // No farther than the curvature is known.
      const double turn_rad =
          std::max(step.head<3>().norm(), rad_a_unit_.cwiseProduct(step.cwiseAbs()).maxCoeff());
      const double limit_rad = EdgeProfile::kFine_samples * kStep_rad;
      if (turn_rad > limit_rad) step *= limit_rad / turn_rad;
      x_ += step;
      if (turn_rad < 0.02 * kStep_rad) break;
    }
    return Linearize();
  }

  const EdgeVector& x() const { return x_; }
  EdgeMatrix Covariance() const {
    const EdgeMatrix inverse = H_.inverse();
    return inverse * (spread_ + prior_) * inverse;
  }

 private:
  bool Linearize() {
    EdgeMatrix curvature = EdgeMatrix::Zero(), squares = EdgeMatrix::Zero();
    EdgeVector gradient = EdgeVector::Zero(), group_gradient = EdgeVector::Zero();
    spread_.setZero();
    int group = -1;
    const auto close_group = [&] {
      spread_ += group_gradient * group_gradient.transpose();
      group_gradient.setZero();
    };
    for (const PlacedEdge& p : placed_) {
      const Sample sample = At(p.edge->fine, p.edge->J.dot(x_.transpose()) + p.offset);
      if (p.group != group) close_group();
      group = p.group;
      const EdgeVector J = p.edge->J.transpose();
      const EdgeMatrix JJ = J * J.transpose();
      curvature -= sample.bend * JJ;
      squares += sample.slope * sample.slope * JJ;
      gradient += sample.slope * J;
      group_gradient += sample.slope * J;
    }
    close_group();
    // In units in which curvature and squared gradients agree, as of a log likelihood.
    const double scale = curvature.topLeftCorner<2, 2>().trace();
    const double unit = squares.topLeftCorner<2, 2>().trace() / scale;
    if (!(scale > 0.0) || !(unit > 0.0)) return false;
    H_ = prior_ + NonNegative(curvature / unit);
    b_ = gradient / unit + prior_ * (expected_ - x_);
    spread_ /= unit * unit;
    return true;
  }

  const std::vector<PlacedEdge>& placed_;
  EdgeVector expected_, x_, b_;
  EdgeMatrix prior_, H_, spread_;
  EdgeVector rad_a_unit_;  // by which outlines move on average, of what is not the rotation
};

// Scores of rotations about an axis, with the image late by `delay_s`.
std::vector<double> ScoresAlong(const std::vector<PlacedEdge>& placed, int axis, double delay_s,
                                size_t every) {
  std::vector<double> scores;
  for (int i = -kSteps; i <= kSteps; ++i) {
    double score = 0.0;
    for (size_t k = 0; k < placed.size(); k += every) {
      const PlacedEdge& p = placed[k];
      if (p.edge->is_upright != (axis == 1)) continue;
      const double turned = p.edge->J[axis] * i * kStep_rad + p.edge->J[kEdgeDelay] * delay_s;
      score += At(p.edge->coarse, turned + p.offset).value;
    }
    scores.push_back(score);
  }
  return scores;
}

size_t Best(const std::vector<double>& scores) {
  return static_cast<size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
}

double RotationOf_rad(size_t step) { return (static_cast<int>(step) - kSteps) * kStep_rad; }

}  // namespace

void PlaceEdges(const EdgeProfiles& edges, const EdgeVector& moved, int image,
                std::vector<PlacedEdge>* placed) {
  constexpr int kGroups = 1 << 16;  // of an image at most
  for (const EdgeProfile& edge : edges.profiles) {
    placed->push_back({&edge, edge.J.dot(moved.transpose()), image * kGroups + edge.group});
  }
}

EdgeSearch SearchAxis(const std::vector<PlacedEdge>& placed, int axis, double delay_s) {
  const std::vector<double> scores = ScoresAlong(placed, axis, delay_s, 1);
  const size_t best = Best(scores);
  return {RotationOf_rad(best), delay_s, StandsOut(scores[best], Elsewhere(scores, best))};
}

EdgeSearch SearchDelay(const std::vector<PlacedEdge>& placed, double max_delay_s) {
  constexpr double kStep_s = 0.004;
  constexpr size_t kEnough = 4000;
  const size_t every = placed.size() / kEnough + 1;
  const int steps = static_cast<int>(std::ceil(max_delay_s / kStep_s));
  std::vector<double> all;
  for (int k = -steps; k <= steps; ++k) {
    const std::vector<double> scores = ScoresAlong(placed, 1, k * kStep_s, every);
    all.insert(all.end(), scores.begin(), scores.end());
  }
  const size_t best = Best(all), best_step = best % kAxisSteps;
  const int k = static_cast<int>(best / kAxisSteps) - steps;
  return {RotationOf_rad(best_step), k * kStep_s, StandsOut(all[best], Elsewhere(all, best_step))};
}

EdgeFit FitEdges(const std::vector<PlacedEdge>& placed, const EdgePrior& prior,
                 const EdgeVector& start) {
  FineSearch search(placed, prior, start);
  EdgeFit fit;
  fit.has_converged = search.Solve();
  if (!fit.has_converged) return fit;
  fit.x = search.x();
  fit.covariance = search.Covariance();
  return fit;
}

}  // namespace tvl
