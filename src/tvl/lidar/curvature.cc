#include "tvl/lidar/curvature.h"

#include <algorithm>
#include <cmath>

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
  std::vector<int> holes;  // among the entries before; after one: wider than gap
};

ClosedRing Close(const RingPoints& ring, size_t pad) {
  constexpr float kTwoPi = static_cast<float>(2.0 * kPi);
  ClosedRing out;
  const size_t n = ring.range_m.size(), total = n + 2 * pad;
  out.pad = pad;
  out.range_m.resize(total), out.angle_rad.resize(total);
  std::copy(ring.range_m.end() - static_cast<std::ptrdiff_t>(pad), ring.range_m.end(),
            out.range_m.begin());
  std::copy(ring.range_m.begin(), ring.range_m.end(),
            out.range_m.begin() + static_cast<std::ptrdiff_t>(pad));
  std::copy_n(ring.range_m.begin(), pad, out.range_m.end() - static_cast<std::ptrdiff_t>(pad));
  for (size_t k = 0; k < pad; ++k) {
    out.angle_rad[k] = ring.angle_rad[n - pad + k] - kTwoPi;
    out.angle_rad[n + pad + k] = ring.angle_rad[k] + kTwoPi;
  }
  std::copy(ring.angle_rad.begin(), ring.angle_rad.end(),
            out.angle_rad.begin() + static_cast<std::ptrdiff_t>(pad));
  out.inverse_sum.resize(total + 1), out.angle_sum.resize(total + 1);
  double inverse = 0.0, angle = 0.0;
  for (size_t k = 0; k < total; ++k) {
    out.inverse_sum[k] = inverse, out.angle_sum[k] = angle;
    inverse += 1.0 / static_cast<double>(out.range_m[k]);
    angle += static_cast<double>(out.angle_rad[k]);
  }
  out.inverse_sum[total] = inverse, out.angle_sum[total] = angle;
  return out;
}

bool HoleAfter(const ClosedRing& ring, size_t k) { return ring.holes[k + 1] > ring.holes[k]; }

ClosedRing FindBreaks(ClosedRing ring, double column_rad, const CurvatureOptions& options) {
  const size_t total = ring.range_m.size();
  const float gap_rad = static_cast<float>((options.max_gap_columns + 0.5) * column_rad);
  const float step_m = static_cast<float>(options.occlusion_step_m);
  ring.run_left.resize(total), ring.run_right.resize(total), ring.holes.resize(total);
  ring.run_left[0] = ring.holes[0] = ring.run_right[total - 1] = 0;
  for (size_t k = 0; k + 1 < total; ++k) {
    const bool hole = ring.angle_rad[k + 1] - ring.angle_rad[k] > gap_rad;
    const bool broken = hole || std::abs(ring.range_m[k + 1] - ring.range_m[k]) > step_m;
    ring.holes[k + 1] = ring.holes[k] + hole;
    ring.run_left[k + 1] = broken ? 0 : ring.run_left[k] + 1;
  }
  for (size_t k = total - 1; k-- > 0;) {
    ring.run_right[k] = ring.run_left[k + 1] == 0 ? 0 : ring.run_right[k + 1] + 1;
  }
  return ring;
}

// Eq. (1) on inverse ranges, each side weighted by the other's mean distance in angle.
float CurvatureAt(const ClosedRing& ring, size_t k, size_t w) {
  const double count = static_cast<double>(w);
  const double own = 1.0 / static_cast<double>(ring.range_m[k]);
  const double own_angle = count * static_cast<double>(ring.angle_rad[k]);
  const double left = ring.inverse_sum[k] - ring.inverse_sum[k - w] - count * own;
  const double right = ring.inverse_sum[k + 1 + w] - ring.inverse_sum[k + 1] - count * own;
  const double left_angle = own_angle - (ring.angle_sum[k] - ring.angle_sum[k - w]);
  const double right_angle = ring.angle_sum[k + 1 + w] - ring.angle_sum[k + 1] - own_angle;
  const double span = std::max(left_angle + right_angle, 1e-9);
  return static_cast<float>(std::abs(right_angle * left + left_angle * right) /
                            (count * span * own));
}

// Marks the far side of range steps, whose surface goes on unseen behind the near one.
void MarkOccluded(const ClosedRing& ring, const CurvatureOptions& options,
                  std::vector<PointCurvature>* out) {
  const size_t n = out->size(), reach = static_cast<size_t>(options.half_window);
  for (size_t i = 0; i < n; ++i) {
    const size_t k = i + ring.pad;
    if (ring.run_left[k + 1] != 0 || HoleAfter(ring, k)) continue;
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
                                             const CurvatureOptions& options) {
  TVL_CHECK(ring.range_m.size() == ring.angle_rad.size());
  const size_t n = ring.range_m.size();
  std::vector<PointCurvature> out(n);
  if (n < 2 * static_cast<size_t>(options.half_window) + 1) return out;
  const size_t pad = std::min(n, static_cast<size_t>(options.max_half_window) + 1);
  const ClosedRing closed = FindBreaks(Close(ring, pad), column_rad, options);
  const int least = options.half_window, most = static_cast<int>(pad) - 1;
  const size_t near = static_cast<size_t>(least);
  const float columns_at_1m = static_cast<float>(options.half_window_m / column_rad);
  const float parallel_share = static_cast<float>(options.parallel_share);
  for (size_t i = 0; i < n; ++i) {
    const size_t k = i + pad;
    out[i].unreliable = IsParallel(closed, k, parallel_share);
    if (closed.holes[k + near] != closed.holes[k - near]) continue;
    const int wanted = std::min(static_cast<int>(columns_at_1m / closed.range_m[k]) + 1, most);
    // Wide windows end at breaks of the surface; only the narrow one looks across.
    const int window = std::max(least, std::min({wanted, closed.run_left[k], closed.run_right[k]}));
    out[i].window = static_cast<int16_t>(window);
    out[i].c = CurvatureAt(closed, k, static_cast<size_t>(window));
  }
  MarkOccluded(closed, options, &out);
  return out;
}

}  // namespace tvl
