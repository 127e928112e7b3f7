#include "tvl/slam/repetition.h"

#include <algorithm>
#include <cstring>

#include "tvl/base/rng.h"

namespace tvl {
namespace {

// Single values look alike now and then, so many of them all over the data never do.
constexpr size_t kSamples = 512;

uint64_t Combine(uint64_t hash, uint64_t value) { return Rng::Mix(hash ^ Rng::Mix(value)); }

}  // namespace

uint64_t Fingerprint(const LidarScan& scan) {
  if (scan.points.empty()) return 0;
  uint64_t hash = scan.size();
  const size_t step = std::max<size_t>(1, scan.size() / kSamples);
  for (size_t i = 0; i < scan.size(); i += step) {
    for (int axis = 0; axis < 3; ++axis) {
      uint32_t bits = 0;
      std::memcpy(&bits, &scan.points[i][axis], sizeof(bits));
      hash = Combine(hash, bits);
    }
  }
  return hash;
}

uint64_t Fingerprint(const cv::Mat& image) {
  if (image.empty()) return 0;
  const size_t row_bytes = static_cast<size_t>(image.cols) * image.elemSize();
  uint64_t hash = image.total();
  const size_t total = static_cast<size_t>(image.rows) * row_bytes;
  const size_t step = std::max<size_t>(1, total / (16 * kSamples)) | 1;  // not a row's multiple
  for (size_t i = 0; i < total; i += step) {
    hash = Combine(hash, image.ptr(static_cast<int>(i / row_bytes))[i % row_bytes]);
  }
  return hash;
}

Repetition RepetitionCheck::Check(const SensorFrame& frame) {
  Repetition repetition;
  if (frame.scan != nullptr) {
    const uint64_t scan = Fingerprint(*frame.scan);
    repetition.scan = scan != 0 && scan == last_scan_;
    last_scan_ = scan;
  }
  const uint64_t image = Fingerprint(frame.image);
  repetition.image = image != 0 && image == last_image_;
  if (image != 0) last_image_ = image;
  return repetition;
}

}  // namespace tvl
