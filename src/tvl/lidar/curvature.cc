#include "tvl/lidar/curvature.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

// The ring with `pad` points of its other end on either side, prefix sums, and for each point how
// far it is to the next break of the surface.
struct ClosedRing {
  size_t pad = 0;
  std::vector<float> range_m, angle_rad;
  std::vector<double> inverse_sum, angle_sum;  // of the entries before
  std::vector<int> run_left, run_right;        // points of the same surface on that side
  std::vector<uint8_t> hole_after;             // the next point is more than max_gap away
};

// Does the surface end between two neighbours?
bool Breaks(float near_m, float far_m, float step_m) { return std::abs(far_m - near_m) > step_m; }

ClosedRing Close(const RingPoints& ring, double column_rad, const CurvatureOptions& options) {
  constexpr float kTwoPi = static_cast<float>(2.0 * kPi);
  ClosedRing out;
  const size_t n = ring.range_m.size();
  out.pad = std::min(n, static_cast<size_t>(options.max_half_window) + 1);
  const size_t total = n + 2 * out.pad;
  out.range_m.resize(total), out.angle_rad.resize(total);
  out.inverse_sum.assign(total + 1, 0.0), out.angle_sum.assign(total + 1, 0.0);
  for (size_t k = 0; k < total; ++k) {
    const size_t i = (k + n - out.pad) % n;
    const float turn = k < out.pad ? -kTwoPi : (k >= n + out.pad ? kTwoPi : 0.0f);
    out.range_m[k] = ring.range_m[i];
    out.angle_rad[k] = ring.angle_rad[i] + turn;
    out.inverse_sum[k + 1] = out.inverse_sum[k] + 1.0 / static_cast<double>(out.range_m[k]);
    out.angle_sum[k + 1] = out.angle_sum[k] + static_cast<double>(out.angle_rad[k]);
  }
  const float gap_rad = static_cast<float>((options.max_gap_columns + 0.5) * column_rad);
  const float step_m = static_cast<float>(options.occlusion_step_m);
  out.run_left.assign(total, 0), out.run_right.assign(total, 0), out.hole_after.assign(total, 0);
  for (size_t k = 0; k + 1 < total; ++k) {
    out.hole_after[k] = out.angle_rad[k + 1] - out.angle_rad[k] > gap_rad;
    const bool broken = out.hole_after[k] || Breaks(out.range_m[k], out.range_m[k + 1], step_m);
    out.run_left[k + 1] = broken ? 0 : out.run_left[k] + 1;
  }
  for (size_t k = total - 1; k-- > 0;) {
    out.run_right[k] = out.run_left[k + 1] == 0 ? 0 : out.run_right[k + 1] + 1;
  }
  return out;
}

// Is there a hole among the `w` neighbours on either side?
bool HoleNear(const ClosedRing& ring, size_t k, size_t w) {
  for (size_t j = k - w; j < k + w; ++j) {
    if (ring.hole_after[j]) return true;
  }
  return false;
}

float CurvatureAt(const ClosedRing& ring, size_t k, size_t w) {
  const double count = static_cast<double>(w);
  const double own = 1.0 / static_cast<double>(ring.range_m[k]);
  const double angle = static_cast<double>(ring.angle_rad[k]);
  const auto mean = [count](const std::vector<double>& sum, size_t begin, size_t end) {
    return (sum[end] - sum[begin]) / count;
  };
  const double left = mean(ring.inverse_sum, k - w, k) - own;
  const double right = mean(ring.inverse_sum, k + 1, k + 1 + w) - own;
  const double left_angle = angle - mean(ring.angle_sum, k - w, k);
  const double right_angle = mean(ring.angle_sum, k + 1, k + 1 + w) - angle;
  const double span = std::max(left_angle + right_angle, 1e-9);
  return static_cast<float>(std::abs(right_angle * left + left_angle * right) / (span * own));
}

// Marks the far side of range steps, whose surface goes on unseen behind the near one.
void MarkOccluded(const ClosedRing& ring, const CurvatureOptions& options,
                  std::vector<PointCurvature>* out) {
  const size_t n = out->size(), reach = static_cast<size_t>(options.half_window);
  const float step_m = static_cast<float>(options.occlusion_step_m);
  for (size_t i = 0; i < n; ++i) {
    const size_t k = i + ring.pad;
    if (ring.hole_after[k] || !Breaks(ring.range_m[k], ring.range_m[k + 1], step_m)) continue;
    const bool next_is_far = ring.range_m[k + 1] > ring.range_m[k];
    for (size_t j = 0; j < reach; ++j) {
      (*out)[(next_is_far ? i + 1 + j : i + n - j % n) % n].unreliable = true;
    }
  }
}

bool IsParallel(const ClosedRing& ring, size_t k, float share) {
  const float limit_m = share * ring.range_m[k];
  return std::abs(ring.range_m[k - 1] - ring.range_m[k]) > limit_m &&
         std::abs(ring.range_m[k + 1] - ring.range_m[k]) > limit_m;
}

}  // namespace

void CurvatureOptions::Check() const {
  TVL_CHECK_INPUT(half_window >= 1 && half_window <= max_half_window)
      << "features.half_window: want 1..max_half_window, is " << half_window;
  TVL_CHECK_INPUT(max_half_window <= 200)
      << "features.max_half_window: want at most 200, is " << max_half_window;
  TVL_CHECK_INPUT(half_window_m >= 0.0) << "features.half_window_m: must not be negative";
  TVL_CHECK_INPUT(occlusion_step_m > 0.0) << "features.occlusion_step_m: must be positive";
  TVL_CHECK_INPUT(max_gap_columns >= 1) << "features.max_gap_columns: must be positive";
  TVL_CHECK_INPUT(parallel_share > 0.0) << "features.parallel_share: must be positive";
}

std::vector<PointCurvature> ComputeCurvature(const RingPoints& ring, double column_rad,
                                             const CurvatureOptions& options,
                                             std::vector<PointCurvature> reuse) {
  TVL_CHECK(ring.range_m.size() == ring.angle_rad.size());
  std::vector<PointCurvature> out = std::move(reuse);
  const size_t n = ring.range_m.size();
  out.assign(n, PointCurvature{});
  if (n < 2 * static_cast<size_t>(options.half_window) + 1) return out;
  const ClosedRing closed = Close(ring, column_rad, options);
  const int least = options.half_window;
  const float columns_at_1m = static_cast<float>(options.half_window_m / column_rad);
  for (size_t i = 0; i < n; ++i) {
    const size_t k = i + closed.pad;
    out[i].unreliable = IsParallel(closed, k, static_cast<float>(options.parallel_share));
    const int wanted = std::min(static_cast<int>(columns_at_1m / closed.range_m[k]) + 1,
                                static_cast<int>(closed.pad) - 1);
    // Wide windows end at breaks of the surface; only the narrow one looks across.
    const int window = std::max(least, std::min({wanted, closed.run_left[k], closed.run_right[k]}));
    if (HoleNear(closed, k, static_cast<size_t>(least))) continue;
    out[i].window = static_cast<int16_t>(window);
    out[i].c = CurvatureAt(closed, k, static_cast<size_t>(window));
  }
  MarkOccluded(closed, options, &out);
  return out;
}

}  // namespace tvl
