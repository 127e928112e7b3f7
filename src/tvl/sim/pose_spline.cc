#include "tvl/sim/pose_spline.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d LogRotation(const Quaterniond& q) { return Rigid3d(q, Vector3d::Zero()).Log().head<3>(); }

Quaterniond ExpRotation(const Vector3d& w) {
  Vector6d xi = Vector6d::Zero();
  xi.head<3>() = w;
  return Rigid3d::Exp(xi).q();
}

}  // namespace

PoseSpline::PoseSpline(std::vector<Rigid3d> control, double start_s, double interval_s)
    : control_(std::move(control)), start_s_(start_s), interval_s_(interval_s) {
  TVL_CHECK(control_.size() >= 4) << "a cubic spline needs 4 poses, got " << control_.size();
  TVL_CHECK(interval_s_ > 0.0);
}

Rigid3d PoseSpline::At(double time_s) const {
  const double last = static_cast<double>(control_.size()) - 2.0;
  const double u = std::clamp((time_s - start_s_) / interval_s_, 1.0, last);
  const auto i = static_cast<size_t>(std::min(std::floor(u), last - 1.0));
  const double x = u - static_cast<double>(i), x2 = x * x, x3 = x2 * x;
  // Cumulative basis: the weights of the steps between neighbouring control poses.
  const double b1 = (5.0 + 3.0 * x - 3.0 * x2 + x3) / 6.0;
  const double b2 = (1.0 + 3.0 * x + 3.0 * x2 - 2.0 * x3) / 6.0;
  const double b3 = x3 / 6.0;
  const Rigid3d *p0 = &control_[i - 1], *p1 = &control_[i], *p2 = &control_[i + 1],
                *p3 = &control_[i + 2];
  const Vector3d t =
      p0->t() + b1 * (p1->t() - p0->t()) + b2 * (p2->t() - p1->t()) + b3 * (p3->t() - p2->t());
  const Quaterniond q = p0->q() * ExpRotation(b1 * LogRotation(p0->q().conjugate() * p1->q())) *
                        ExpRotation(b2 * LogRotation(p1->q().conjugate() * p2->q())) *
                        ExpRotation(b3 * LogRotation(p2->q().conjugate() * p3->q()));
  return {q, t};
}

std::vector<Rigid3d> SmoothPoses(const std::vector<Rigid3d>& poses, double sigma_poses) {
  const int reach = static_cast<int>(std::ceil(3.0 * sigma_poses));
  const int n = static_cast<int>(poses.size());
  std::vector<Rigid3d> smooth;
  smooth.reserve(poses.size());
  for (int i = 0; i < n; ++i) {
    const Rigid3d& centre = poses[static_cast<size_t>(i)];
    // The same reach to both sides, so that the ends are not pulled inwards.
    const int here = std::min({reach, i, n - 1 - i});
    Vector3d rotation = Vector3d::Zero(), position = Vector3d::Zero();
    double total = 0.0;
    for (int j = i - here; j <= i + here; ++j) {
      const double d = (j - i) / sigma_poses, weight = std::exp(-0.5 * d * d);
      const Rigid3d& other = poses[static_cast<size_t>(j)];
      rotation += weight * LogRotation(centre.q().conjugate() * other.q());
      position += weight * other.t();
      total += weight;
    }
    smooth.emplace_back(centre.q() * ExpRotation(rotation / total), position / total);
  }
  return smooth;
}

std::vector<Rigid3d> ExtendPoses(const std::vector<Rigid3d>& poses, int count) {
  TVL_CHECK(poses.size() >= 2) << "a velocity needs two poses";
  const Rigid3d forward = poses[poses.size() - 2].Inverse() * poses.back();
  const Rigid3d backward = poses[1].Inverse() * poses.front();
  std::vector<Rigid3d> extended = poses;
  for (int i = 0; i < count; ++i) {
    extended.insert(extended.begin(), extended.front() * backward);
    extended.push_back(extended.back() * forward);
  }
  return extended;
}

}  // namespace tvl::sim
