#include "tvl/loop/lidar_descriptor_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/loop/lidar_descriptor_cells.h"

namespace tvl {
namespace {

constexpr int kRings = LidarDescriptor::kRings, kAngles = LidarDescriptor::kAngles;
// The half turn that fits worse at the coarse level is dropped unless it is this close.
constexpr double kSecondTurn = 0.85;
// Shifts this far apart are different placements: cars and door steps are smaller.
constexpr double kElsewhere_m = 3.0;
// Pattern search: first and last step; the yaw's step is what moves a point at 20 m as far.
constexpr double kFirstStep_m = 0.6, kLastStep_m = 0.1, kLever_m = 20.0;

cv::Mat BlurredImage(const std::vector<PlaceCell>& cells, const LidarDescriptorOptions& options) {
  cv::Mat image = PlaceImage(cells, 0.0, options.grid(), options);
  cv::GaussianBlur(image, image, cv::Size(5, 5), 1.0, 1.0, cv::BORDER_CONSTANT);
  return image;
}

// Value at a place in pixels, 0 outside.
float Sample(const cv::Mat& image, float u, float v) {
  const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
  if (i < 0 || j < 0 || i + 1 >= image.cols || j + 1 >= image.rows) return 0.0F;
  const float fu = u - static_cast<float>(i), fv = v - static_cast<float>(j);
  const float* row = image.ptr<float>(j) + i;
  const float* next = image.ptr<float>(j + 1) + i;
  return (1 - fv) * ((1 - fu) * row[0] + fu * row[1]) + fv * ((1 - fu) * next[0] + fu * next[1]);
}

}  // namespace

double SpectrumYaw(const std::vector<int8_t>& history, const std::vector<int8_t>& current) {
  TVL_CHECK(history.size() == kRings * kAngles && current.size() == history.size());
  std::array<int, kAngles> sum{};
  for (size_t r = 0; r < kRings; ++r) {
    // The ring twice over, so that no index wraps.
    std::array<int8_t, 2 * kAngles> ring;
    std::copy_n(&history[r * kAngles], kAngles, ring.begin());
    std::copy_n(&history[r * kAngles], kAngles, ring.begin() + kAngles);
    const int8_t* other = &current[r * kAngles];
    for (size_t shift = 0; shift < kAngles; ++shift) {
      int dot = 0;
      for (size_t a = 0; a < kAngles; ++a) dot += ring[a + shift] * other[a];
      sum[shift] += dot;
    }
  }
  const size_t best = static_cast<size_t>(std::max_element(sum.begin(), sum.end()) - sum.begin());
  const double left = sum[(best + kAngles - 1) % kAngles], right = sum[(best + 1) % kAngles];
  const double curvature = left - 2.0 * sum[best] + right;
  const double offset = curvature < 0.0 ? 0.5 * (left - right) / curvature : 0.0;
  const double yaw = (static_cast<double>(best) + offset) * kPi / kAngles;
  return yaw < 0.0 ? yaw + kPi : yaw >= kPi ? yaw - kPi : yaw;
}

float PlaceEnergy(const std::vector<PlaceCell>& cells, const LidarDescriptorOptions& options) {
  const cv::Mat field = BlurredImage(cells, options);
  const int half = options.grid() / 2;
  float energy = 0.0F;
  for (const PlaceCell& cell : cells) {
    energy += cell.weight() * field.at<float>(cell.y + half, cell.x + half);
  }
  return energy;
}

PlaceMatcher::PlaceMatcher(const LidarDescriptor& current, double max_offset_m,
                           const LidarDescriptorOptions& options)
    : options_(options),
      max_offset_m_(max_offset_m),
      spectrum_(current.spectrum),
      energy_(current.energy),
      field_(BlurredImage(current.cells, options)) {
  cv::dft(PlaceImage(current.cells, 0.0, options.grid() / 2, options), coarse_);
}

PlaceMatcher::CoarseResult PlaceMatcher::Coarse(const LidarDescriptor& history,
                                                double yaw_rad) const {
  const int side = coarse_.rows;
  const double pixel_m = 2.0 * options_.range_m / side;
  cv::Mat correlation;
  cv::dft(PlaceImage(history.cells, -yaw_rad, side, options_), correlation);
  cv::mulSpectrums(coarse_, correlation, correlation, 0, true);
  cv::dft(correlation, correlation, cv::DFT_INVERSE | cv::DFT_SCALE);
  const int reach = std::min(static_cast<int>(max_offset_m_ / pixel_m), side / 2 - 1);
  const auto for_each_shift = [&](const auto& body) {
    for (int y = -reach; y <= reach; ++y) {
      const float* row = correlation.ptr<float>((y + side) % side);
      for (int x = -reach; x <= reach; ++x) body(x, y, row[(x + side) % side]);
    }
  };
  int best_x = 0, best_y = 0;
  float best = -1.0F, elsewhere = 0.0F;
  for_each_shift([&](int x, int y, float value) {
    if (value > best) best = value, best_x = x, best_y = y;
  });
  for_each_shift([&](int x, int y, float value) {
    if (std::hypot(x - best_x, y - best_y) * pixel_m >= kElsewhere_m) {
      elsewhere = std::max(elsewhere, value);
    }
  });
  return {{yaw_rad, best_x * pixel_m, best_y * pixel_m, best}, elsewhere};
}

double PlaceMatcher::Correlation(const std::vector<PlaceCell>& history, const Placement& at) const {
  const float c = static_cast<float>(std::cos(at.yaw_rad));
  const float s = static_cast<float>(std::sin(at.yaw_rad));
  const float centre = 0.5F * static_cast<float>(field_.rows) - 0.5F;
  const float u0 = centre + static_cast<float>(at.shift_x_m / options_.cell_m);
  const float v0 = centre + static_cast<float>(at.shift_y_m / options_.cell_m);
  double sum = 0.0;
  for (const PlaceCell& cell : history) {
    const float x = static_cast<float>(cell.x) + 0.5F, y = static_cast<float>(cell.y) + 0.5F;
    sum += cell.weight() * Sample(field_, c * x + s * y + u0, -s * x + c * y + v0);
  }
  return sum;
}

PlaceMatcher::Placement PlaceMatcher::Refined(const LidarDescriptor& history,
                                              Placement start) const {
  Placement best = start;
  best.correlation = Correlation(history.cells, best);
  for (double step = kFirstStep_m; step > kLastStep_m; step *= 0.5) {
    for (int moved = 1, round = 0; moved != 0 && round < 4; ++round) {
      moved = 0;
      for (int direction = 0; direction < 6; ++direction) {
        const double signed_step = direction % 2 == 0 ? step : -step;
        Placement next = best;
        if (direction < 2) next.yaw_rad += signed_step / kLever_m;
        if (direction / 2 == 1) next.shift_x_m += signed_step;
        if (direction / 2 == 2) next.shift_y_m += signed_step;
        next.correlation = Correlation(history.cells, next);
        if (next.correlation <= best.correlation) continue;
        best = next;
        moved = 1;
      }
    }
  }
  return best;
}

PlaceMatch PlaceMatcher::Match(const LidarDescriptor& history) const {
  PlaceMatch match;
  if (!(history.energy > 0.0F) || !(energy_ > 0.0F)) return match;
  const double yaw = SpectrumYaw(history.spectrum, spectrum_);
  CoarseResult first = Coarse(history, yaw), second = Coarse(history, yaw + kPi);
  if (second.best.correlation > first.best.correlation) std::swap(first, second);
  Placement best = Refined(history, first.best);
  if (second.best.correlation > kSecondTurn * first.best.correlation) {
    const Placement other = Refined(history, second.best);
    if (other.correlation > best.correlation) best = other;
  }
  if (first.best.correlation > 0.0) {
    match.ambiguity = std::max(first.elsewhere, second.best.correlation) / first.best.correlation;
  }
  // p_current = R(-yaw) p_history + shift, so T_history_current = (yaw, -R(yaw) shift).
  const double c = std::cos(best.yaw_rad), s = std::sin(best.yaw_rad);
  match.yaw_rad = std::remainder(best.yaw_rad, 2.0 * kPi);
  match.x_m = -(c * best.shift_x_m - s * best.shift_y_m);
  match.y_m = -(s * best.shift_x_m + c * best.shift_y_m);
  match.similarity = best.correlation / std::sqrt(static_cast<double>(history.energy) * energy_);
  return match;
}

}  // namespace tvl
