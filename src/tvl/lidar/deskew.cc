#include "tvl/lidar/deskew.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl {
namespace {

constexpr int kSteps = 128;  // poses over the span of times; between them linear

// Pose at the start of a step and its change over the step. A step of a sweep turns by about
// 1 mrad even in a hard turn, where the error of the straight line is 1e-7 of the range.
struct Step {
  Eigen::Matrix3f R, dR;
  Eigen::Vector3f t, dt;
};

std::vector<Step> Table(const Rigid3d& T_prev_cur, double first_share, double last_share) {
  const Vector6d xi = T_prev_cur.Log();
  std::vector<Step> table(kSteps);
  Rigid3d begin = Rigid3d::Exp(first_share * xi);
  for (int k = 0; k < kSteps; ++k) {
    const double share = first_share + (last_share - first_share) * (k + 1) / kSteps;
    const Rigid3d end = Rigid3d::Exp(share * xi);
    table[static_cast<size_t>(k)] = {begin.R().cast<float>(), (end.R() - begin.R()).cast<float>(),
                                     begin.t().cast<float>(), (end.t() - begin.t()).cast<float>()};
    begin = end;
  }
  return table;
}

}  // namespace

std::vector<Eigen::Vector3f> DeskewPoints(const std::vector<Eigen::Vector3f>& points,
                                          const std::vector<float>& time_offset_s,
                                          const Rigid3d& T_prev_cur, double period_s) {
  TVL_CHECK(points.size() == time_offset_s.size());
  TVL_CHECK(period_s > 0.0);
  if (points.empty()) return {};
  const auto [first, last] = std::minmax_element(time_offset_s.begin(), time_offset_s.end());
  const float begin_s = *first, span_s = *last - *first;
  if (span_s == 0.0f && begin_s == 0.0f) return points;
  const std::vector<Step> table = Table(T_prev_cur, static_cast<double>(begin_s) / period_s,
                                        static_cast<double>(*last) / period_s);
  const float steps_per_s = span_s > 0.0f ? kSteps / span_s : 0.0f;
  std::vector<Eigen::Vector3f> out(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const float position = (time_offset_s[i] - begin_s) * steps_per_s;
    const int k = std::min(static_cast<int>(position), kSteps - 1);
    const float f = position - static_cast<float>(k);
    const Step& step = table[static_cast<size_t>(k)];
    const Eigen::Vector3f& p = points[i];
    out[i] = step.R * p + step.t + f * (step.dR * p + step.dt);
  }
  return out;
}

}  // namespace tvl
