#include "tvl/slam/frame_check.h"

#include <cmath>
#include <string>
#include <utility>

namespace tvl {
namespace {

using Kind = FrameFault::Kind;

constexpr float kMaxCoordinate_m = 1e4f;
constexpr double kMaxSweeps = 2.0;  // an offset is at most half a sweep

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

bool IsOfOneLength(const LidarScan& scan) {
  const auto fits = [&](size_t size) { return size == 0 || size == scan.size(); };
  return fits(scan.intensity.size()) && fits(scan.ring.size()) && fits(scan.time_offset_s.size());
}

// Comparisons are written so that NaN fails.
bool IsUsablePoint(const LidarScan& scan, size_t i, float max_offset_s) {
  const Eigen::Vector3f& p = scan.points[i];
  return std::abs(p.x()) < kMaxCoordinate_m && std::abs(p.y()) < kMaxCoordinate_m &&
         std::abs(p.z()) < kMaxCoordinate_m &&
         (scan.intensity.empty() || std::isfinite(scan.intensity[i])) &&
         (scan.time_offset_s.empty() || std::abs(scan.time_offset_s[i]) <= max_offset_s);
}

LidarScan UsablePoints(const LidarScan& scan, float max_offset_s) {
  LidarScan usable;
  for (size_t i = 0; i < scan.size(); ++i) {
    if (!IsUsablePoint(scan, i, max_offset_s)) continue;
    usable.points.push_back(scan.points[i]);
    if (!scan.intensity.empty()) usable.intensity.push_back(scan.intensity[i]);
    if (!scan.ring.empty()) usable.ring.push_back(scan.ring[i]);
    if (!scan.time_offset_s.empty()) usable.time_offset_s.push_back(scan.time_offset_s[i]);
  }
  return usable;
}

size_t CountUsable(const LidarScan& scan, float max_offset_s) {
  size_t count = 0;
  for (size_t i = 0; i < scan.size(); ++i) count += IsUsablePoint(scan, i, max_offset_s);
  return count;
}

void CheckScan(const std::string& name, double sweep_s, SensorFrame* frame) {
  const LidarScan& scan = *frame->scan;
  if (!IsOfOneLength(scan)) {
    frame->faults.push_back({Kind::kOddScan, name + ": its scan has " +
                                                 std::to_string(scan.size()) +
                                                 " points, but other numbers of values for them"});
    frame->scan = nullptr;
    return;
  }
  const float max_offset_s = static_cast<float>(kMaxSweeps * sweep_s);
  const size_t usable = CountUsable(scan, max_offset_s);
  if (usable < scan.size()) {
    frame->faults.push_back(
        {Kind::kInvalidPoints, name + ": " + std::to_string(scan.size() - usable) + " of " +
                                   std::to_string(scan.size()) +
                                   " points are not finite, too far or out of time: dropped"});
    frame->scan = std::make_shared<const LidarScan>(UsablePoints(scan, max_offset_s));
  }
  if (usable > 0) return;
  frame->faults.push_back({Kind::kEmptyScan, name + ": its scan has no valid point"});
  frame->scan = nullptr;
}

void CheckImage(const std::string& name, const Camera& camera, SensorFrame* frame) {
  const cv::Mat& image = frame->image;
  const bool is_known = image.dims == 2 && (image.depth() == CV_8U || image.depth() == CV_16U) &&
                        (image.channels() == 1 || image.channels() == 3);
  const bool is_of_size =
      camera.width_px <= 0 || (image.cols == camera.width_px && image.rows == camera.height_px);
  if (is_known && is_of_size) return;
  if (!is_known) {
    frame->faults.push_back(
        {Kind::kUnreadableImage, name + ": its image has not 8 or 16 bit, grey or colour"});
  } else {
    frame->faults.push_back(
        {Kind::kWrongSizeImage, name + ": its image is " + SizeText(image.cols, image.rows) +
                                    ", the camera's are " +
                                    SizeText(camera.width_px, camera.height_px)});
  }
  frame->image.release();
}

}  // namespace

SensorFrame WithoutOddData(SensorFrame frame, const SensorSetup& setup) {
  const std::string name = "frame " + std::to_string(frame.id);
  if (frame.scan != nullptr) CheckScan(name, setup.lidar.sweep_s, &frame);
  if (!frame.image.empty()) CheckImage(name, setup.calibration.camera, &frame);
  return frame;
}

}  // namespace tvl
