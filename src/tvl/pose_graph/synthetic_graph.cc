#include "tvl/pose_graph/synthetic_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/index.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

constexpr int kTurnSteps = 12;         // keyframes of a turn at a crossing ...
constexpr double kTurnRadius_m = 8.0;  // ... with this radius
constexpr int kMinGap = 50;            // poses between the two of a loop
constexpr double kRevisit_m = 3.0;     // closer than this is the same place
constexpr double kElsewhere_m = 30.0;  // farther than this is another one

Vector6d Noise(double rotation_rad, double translation_m, Rng* rng) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? rotation_rad : translation_m) * rng->Normal();
  return xi;
}

Matrix6d Information(double rotation_rad, double translation_m) {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(1.0 / (rotation_rad * rotation_rad)),
      Eigen::Vector3d::Constant(1.0 / (translation_m * translation_m));
  return diagonal.asDiagonal();
}

// A street grid, seen from a car that turns at random at its crossings and stays inside.
class Drive {
 public:
  Drive(const SyntheticGraphOptions& options, Rng* rng) : options_(options), rng_(rng) {
    x_ = y_ = options.blocks / 2;
  }

  std::vector<Rigid3d> Poses() {
    Rigid3d T;
    std::vector<Rigid3d> poses{T};
    const auto append = [&](double angle_rad, double length_m, int steps) {
      Vector6d xi = Vector6d::Zero();
      xi[2] = angle_rad;
      xi[3] = length_m;
      for (int k = 0; k < steps; ++k) poses.push_back(T = T * Rigid3d::Exp(xi));
    };
    const double straight_m = options_.block_m - 2.0 * kTurnRadius_m;
    const int steps = std::max(1, static_cast<int>(std::round(straight_m)));
    while (static_cast<int>(poses.size()) < options_.poses) {
      append(0.0, straight_m / steps, steps);
      x_ += kAhead[direction_][0];
      y_ += kAhead[direction_][1];
      const int turn = ChooseTurn();
      const double arc_m = turn == 0 ? 2.0 * kTurnRadius_m : 0.5 * kPi * kTurnRadius_m;
      append(turn * 0.5 * kPi / kTurnSteps, arc_m / kTurnSteps, kTurnSteps);
    }
    poses.resize(Index(options_.poses));
    for (Rigid3d& pose : poses) {  // hills, the same on every pass
      Eigen::Vector3d t = pose.t();
      t.z() = 3.0 * std::sin(t.x() / 150.0) * std::cos(t.y() / 130.0);
      pose = Rigid3d(pose.q(), t);
    }
    return poses;
  }

 private:
  static constexpr int kAhead[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

  // -1 right, 0 straight on, 1 left; the next street lies inside the grid.
  int ChooseTurn() {
    for (;;) {
      const int turn = static_cast<int>(rng_->Integer(3)) - 1;
      const int direction = (direction_ + turn + 4) % 4;
      const int x = x_ + kAhead[direction][0], y = y_ + kAhead[direction][1];
      if (x < 0 || y < 0 || x > options_.blocks || y > options_.blocks) continue;
      direction_ = direction;
      return turn;
    }
  }

  const SyntheticGraphOptions& options_;
  Rng* rng_;
  int x_ = 0, y_ = 0, direction_ = 0;
};

// For each pose that has one: the closest earlier pose of the same place.
std::vector<std::pair<int, int>> Revisits(const std::vector<Rigid3d>& truth) {
  std::vector<std::pair<int, int>> revisits;
  for (int j = 0; j < static_cast<int>(truth.size()); ++j) {
    int closest = -1;
    double closest_sq = kRevisit_m * kRevisit_m;
    for (int i = 0; i + kMinGap < j; ++i) {
      const double d_sq = (truth[Index(i)].t() - truth[Index(j)].t()).squaredNorm();
      if (d_sq < closest_sq) {
        closest = i;
        closest_sq = d_sq;
      }
    }
    if (closest >= 0) revisits.emplace_back(closest, j);
  }
  return revisits;
}

struct LabelledLoop {
  PoseConstraint loop;
  char is_false;
};

std::vector<LabelledLoop> TrueLoops(const SyntheticGraphOptions& options,
                                    const std::vector<Rigid3d>& truth, Rng* rng) {
  const auto revisits = Revisits(truth);
  const int count = static_cast<int>(revisits.size());
  TVL_CHECK_INPUT(count >= options.loops)
      << "loops: the drive has only " << count << " revisits, not " << options.loops;
  std::vector<LabelledLoop> loops;
  for (int k = 0; k < options.loops; ++k) {
    const auto& [i, j] =
        revisits[static_cast<size_t>(static_cast<int64_t>(k) * count / options.loops)];
    const Rigid3d noise =
        Rigid3d::Exp(Noise(options.loop_rotation_rad, options.loop_translation_m, rng));
    const Matrix6d information = Information(options.loop_rotation_rad, options.loop_translation_m);
    loops.push_back({{i, j, truth[Index(i)].Inverse() * truth[Index(j)] * noise, information}, 0});
  }
  return loops;
}

// Places far from each other that are said to be a few metres apart.
std::vector<LabelledLoop> FalseLoops(const SyntheticGraphOptions& options,
                                     const std::vector<Rigid3d>& truth, Rng* rng) {
  std::vector<LabelledLoop> loops;
  const Matrix6d information = Information(options.loop_rotation_rad, options.loop_translation_m);
  const int clustered = static_cast<int>(std::lround(options.clustered * options.false_loops));
  const int64_t poses = options.poses - options.cluster_size;
  while (static_cast<int>(loops.size()) < options.false_loops) {
    const int i = static_cast<int>(rng->Integer(poses)), j = static_cast<int>(rng->Integer(poses));
    const Rigid3d& T_i = truth[Index(i)];
    const Rigid3d& T_j = truth[Index(j)];
    if (j - i < kMinGap || (T_i.t() - T_j.t()).norm() < kElsewhere_m) continue;
    const int left = clustered - static_cast<int>(loops.size());
    const int size = left > 0 ? std::min(left, options.cluster_size) : 1;
    const Rigid3d T_i_j(ExpSo3({0.0, 0.0, rng->Uniform(-kPi, kPi)}),
                        {3.0 * rng->Normal(), 3.0 * rng->Normal(), 0.3 * rng->Normal()});
    for (int k = 0; k < size; ++k) {
      const Rigid3d noise =
          Rigid3d::Exp(Noise(options.loop_rotation_rad, options.loop_translation_m, rng));
      const Rigid3d T_ik_i = truth[Index(i + k)].Inverse() * T_i;
      const Rigid3d T_j_jk = T_j.Inverse() * truth[Index(j + k)];
      loops.push_back({{i + k, j + k, T_ik_i * T_i_j * T_j_jk * noise, information}, 1});
    }
  }
  return loops;
}

}  // namespace

void SyntheticGraphOptions::Check() const {
  TVL_CHECK_INPUT(poses >= 2) << "poses must be at least 2";
  TVL_CHECK_INPUT(loops >= 0) << "loops must not be negative";
  TVL_CHECK_INPUT(false_loops >= 0) << "false_loops must not be negative";
  TVL_CHECK_INPUT(false_loops == 0 || poses >= 500) << "poses: false loops need 500 at least";
  TVL_CHECK_INPUT(clustered >= 0.0 && clustered <= 1.0) << "clustered must lie between 0 and 1";
  TVL_CHECK_INPUT(cluster_size >= 1 && cluster_size < 100) << "cluster_size must be 1 to 99";
  TVL_CHECK_INPUT(block_m > 2.0 * kTurnRadius_m) << "block_m must exceed the turns";
  TVL_CHECK_INPUT(blocks >= 2) << "blocks must be at least 2";
  for (const double sigma :
       {odometry_rotation_rad, odometry_translation_m, loop_rotation_rad, loop_translation_m}) {
    TVL_CHECK_INPUT(sigma > 0.0) << "odometry_* and loop_* must be positive";
  }
}

SyntheticGraph MakeSyntheticGraph(const SyntheticGraphOptions& options) {
  options.Check();
  Rng drive_rng(options.seed, 0), odometry_rng(options.seed, 1), loop_rng(options.seed, 2),
      false_rng(options.seed, 3);
  SyntheticGraph result;
  result.truth = Drive(options, &drive_rng).Poses();
  const Matrix6d information =
      Information(options.odometry_rotation_rad, options.odometry_translation_m);
  result.graph.T_world.push_back(result.truth[0]);
  for (int k = 1; k < options.poses; ++k) {
    const Rigid3d noise = Rigid3d::Exp(
        Noise(options.odometry_rotation_rad, options.odometry_translation_m, &odometry_rng));
    const Rigid3d Z = result.truth[Index(k - 1)].Inverse() * result.truth[Index(k)] * noise;
    result.graph.odometry.push_back({k - 1, k, Z, information});
    result.graph.T_world.push_back(result.graph.T_world.back() * Z);
  }
  std::vector<LabelledLoop> loops = TrueLoops(options, result.truth, &loop_rng);
  const std::vector<LabelledLoop> wrong = FalseLoops(options, result.truth, &false_rng);
  loops.insert(loops.end(), wrong.begin(), wrong.end());
  std::stable_sort(loops.begin(), loops.end(), [](const LabelledLoop& a, const LabelledLoop& b) {
    return a.loop.to < b.loop.to;
  });
  for (const LabelledLoop& l : loops) {
    result.graph.loops.push_back(l.loop);
    result.is_false_loop.push_back(l.is_false);
  }
  return result;
}

double AlignedRmse(const std::vector<Rigid3d>& T_world, const std::vector<Rigid3d>& truth) {
  TVL_CHECK(T_world.size() == truth.size() && !truth.empty()) << "as many poses as truths";
  const auto n = static_cast<Eigen::Index>(truth.size());
  Eigen::Matrix3Xd from(3, n), to(3, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    from.col(k) = T_world[static_cast<size_t>(k)].t();
    to.col(k) = truth[static_cast<size_t>(k)].t();
  }
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const Eigen::Vector3d t = T.topRightCorner<3, 1>();
  return std::sqrt((((R * from).colwise() + t) - to).squaredNorm() / static_cast<double>(n));
}

}  // namespace tvl
