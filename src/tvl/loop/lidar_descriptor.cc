#include "tvl/loop/lidar_descriptor.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/loop/lidar_descriptor_cells.h"
#include "tvl/loop/lidar_descriptor_match.h"

namespace tvl {
namespace {

constexpr int kRings = LidarDescriptor::kRings, kAngles = LidarDescriptor::kAngles;
constexpr int kHarmonics = LidarDescriptor::kHarmonics;
using RingSpectra = Eigen::Matrix<float, kRings, kAngles, Eigen::RowMajor>;

// Fades the image out over the outer 30 % of its range: a sharp border would make a spectrum of its
// own, which moves with the sensor.
void FadeOut(cv::Mat* image) {
  const double centre = 0.5 * image->rows - 0.5, range = 0.5 * image->rows;
  for (int y = 0; y < image->rows; ++y) {
    for (int x = 0; x < image->cols; ++x) {
      const double r = std::hypot(x - centre, y - centre) / range;
      const double share = std::clamp((r - 0.7) / 0.3, 0.0, 1.0);
      image->at<float>(y, x) *= static_cast<float>(0.5 + 0.5 * std::cos(kPi * share));
    }
  }
}

// Magnitudes of the Fourier transform, wave number zero at (side / 2, side / 2).
cv::Mat CentredMagnitudes(const cv::Mat& image) {
  cv::Mat transform;
  cv::dft(image, transform, cv::DFT_COMPLEX_OUTPUT);
  const int side = image.rows;
  cv::Mat magnitude(side, side, CV_32F);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const cv::Vec2f z = transform.at<cv::Vec2f>((y + side / 2) % side, (x + side / 2) % side);
      magnitude.at<float>(y, x) = std::sqrt(z[0] * z[0] + z[1] * z[1]);
    }
  }
  return magnitude;
}

float Interpolated(const cv::Mat& image, double x, double y) {
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const float fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
  const float* row = image.ptr<float>(j) + i;
  const float* next = image.ptr<float>(j + 1) + i;
  return (1 - fy) * ((1 - fx) * row[0] + fx * row[1]) + fy * ((1 - fx) * next[0] + fx * next[1]);
}

// Rings of geometrically growing wave number over half a turn (the rest is the same again).
RingSpectra SampleRings(const cv::Mat& magnitude, const LidarDescriptorOptions& options) {
  const double low = 2.0 * options.range_m / options.max_wavelength_m;
  const double high = 2.0 * options.range_m / options.min_wavelength_m;
  const int centre = magnitude.rows / 2;
  RingSpectra rings;
  for (int r = 0; r < kRings; ++r) {
    const double radius = low * std::pow(high / low, r / (kRings - 1.0));
    for (int a = 0; a < kAngles; ++a) {
      const double angle = kPi * a / kAngles;
      rings(r, a) = Interpolated(magnitude, centre + radius * std::cos(angle),
                                 centre + radius * std::sin(angle));
    }
  }
  return rings;
}

// Each ring without its mean, of norm 127: an int8 holds it whatever its shape.
std::vector<int8_t> Quantised(const RingSpectra& rings) {
  std::vector<int8_t> out;
  out.reserve(static_cast<size_t>(kRings * kAngles));
  for (int r = 0; r < kRings; ++r) {
    const Eigen::Matrix<float, 1, kAngles> ring = rings.row(r).array() - rings.row(r).mean();
    const float norm = ring.norm();
    const float scale = norm > 0.0F ? 127.0F / norm : 0.0F;
    for (int a = 0; a < kAngles; ++a) {
      out.push_back(static_cast<int8_t>(std::lround(ring[a] * scale)));
    }
  }
  return out;
}

// Magnitudes of each ring's own transform. Each ring counts the same: else the long waves, alike on
// every street, drown the others.
std::vector<float> Signature(const RingSpectra& rings) {
  cv::Mat transform;
  const cv::Mat input(kRings, kAngles, CV_32F, const_cast<float*>(rings.data()));
  cv::dft(input, transform, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  Eigen::Matrix<float, kRings, kHarmonics, Eigen::RowMajor> out;
  for (int r = 0; r < kRings; ++r) {
    for (int h = 0; h < kHarmonics; ++h) {
      const cv::Vec2f z = transform.at<cv::Vec2f>(r, h);
      out(r, h) = std::sqrt(z[0] * z[0] + z[1] * z[1]);
    }
    const float norm = out.row(r).norm() * std::sqrt(static_cast<float>(kRings));
    if (norm > 0.0F) out.row(r) /= norm;
  }
  return {out.data(), out.data() + out.size()};
}

}  // namespace

int LidarDescriptorOptions::grid() const {
  return 2 * static_cast<int>(std::lround(range_m / cell_m));
}

void LidarDescriptorOptions::Check() const {
  TVL_CHECK_INPUT(range_m > 0.0) << "range_m must be positive: " << range_m;
  TVL_CHECK_INPUT(cell_m > 0.0) << "cell_m must be positive: " << cell_m;
  TVL_CHECK_INPUT(grid() >= 16 && grid() <= 4096)
      << "cell_m must divide twice range_m into 16 to 4096 cells: " << cell_m;
  TVL_CHECK_INPUT(min_height_m >= 0.0) << "min_height_m must not be negative: " << min_height_m;
  TVL_CHECK_INPUT(max_height_m > min_height_m && max_height_m <= 16.0)
      << "max_height_m must be above min_height_m and at most 16 m: " << max_height_m;
  TVL_CHECK_INPUT(ground_cell_m > 0.0) << "ground_cell_m must be positive: " << ground_cell_m;
  TVL_CHECK_INPUT(ground_slope > 0.0) << "ground_slope must be positive: " << ground_slope;
  TVL_CHECK_INPUT(min_wavelength_m > 2.1 * cell_m)
      << "min_wavelength_m must be more than 2.1 cells: " << min_wavelength_m;
  TVL_CHECK_INPUT(max_wavelength_m > min_wavelength_m && max_wavelength_m <= 2.0 * range_m)
      << "max_wavelength_m must be above min_wavelength_m and at most twice range_m: "
      << max_wavelength_m;
}

LidarDescriptor DescribePlace(const KeyframeCloud& cloud, const LidarDescriptorOptions& options) {
  LidarDescriptor place;
  place.cells = StandingCells(cloud, options);
  place.energy = PlaceEnergy(place.cells, options);
  cv::Mat image = PlaceImage(place.cells, 0.0, options.grid(), options);
  FadeOut(&image);
  const RingSpectra rings = SampleRings(CentredMagnitudes(image), options);
  place.spectrum = Quantised(rings);
  place.signature = Signature(rings);
  return place;
}

float SignatureSimilarity(const LidarDescriptor& a, const LidarDescriptor& b) {
  using Map = Eigen::Map<const Eigen::Matrix<float, kRings * kHarmonics, 1>>;
  TVL_CHECK(a.signature.size() == kRings * kHarmonics && b.signature.size() == a.signature.size());
  return Map(a.signature.data()).dot(Map(b.signature.data()));
}

}  // namespace tvl
