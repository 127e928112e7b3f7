#include "tvl/registration/edge_profiles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/units.h"

namespace tvl {
namespace {

using Samples = EdgeProfile::Samples;

constexpr int kReach = EdgeProfile::kReach;
constexpr double kStep_rad = EdgeProfile::kStep_rad;

// An outline: the range jumps by as much, in metres and as a share of the nearer range. Less is
// roughness and sloping road.
constexpr float kJump_m = 0.5f;
constexpr float kJumpShare = 0.1f;
// The nearer surface goes on behind its last point without such a step: no single odd return.
constexpr float kSmooth_m = 0.15f;
constexpr float kSmoothShare = 0.03f;
constexpr double kNearest_m =
    2.0;                       // parallax of the camera is a hundredth of a degree a millimetre
constexpr int kGroup_px = 30;  // wide: what one thing takes

// Of the smoothing for the first search, in samples.
constexpr double kCoarse_samples = 4.0;
// Gradients of less than this many grey levels a sample are noise.
constexpr double kNoise_levels = 2.0;

// Bilinear; `px` must lie inside.
float Level(const cv::Mat& grey, double x, double y) {
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const float ax = static_cast<float>(x - ix), ay = static_cast<float>(y - iy);
  const uint8_t* upper = grey.ptr<uint8_t>(iy) + ix;
  const uint8_t* lower = grey.ptr<uint8_t>(iy + 1) + ix;
  return (1 - ay) * ((1 - ax) * upper[0] + ax * upper[1]) +
         ay * ((1 - ax) * lower[0] + ax * lower[1]);
}

Samples Smooth(const Samples& in, double width_samples) {
  const int reach = static_cast<int>(std::ceil(3.0 * width_samples));
  std::vector<float> kernel;
  for (int i = -reach; i <= reach; ++i) {
    kernel.push_back(static_cast<float>(std::exp(-0.5 * std::pow(i / width_samples, 2))));
  }
  Samples out;
  const int size = static_cast<int>(in.size());
  for (int i = 0; i < size; ++i) {
    float sum = 0.0f, weight = 0.0f;
    for (int k = std::max(0, i - reach); k <= std::min(size - 1, i + reach); ++k) {
      const float w = kernel[static_cast<size_t>(k - i + reach)];
      sum += w * in[static_cast<size_t>(k)];
      weight += w;
    }
    out[static_cast<size_t>(i)] = sum / weight;
  }
  return out;
}

// Of the gradient along `step_px` through `px`, averaged over three parallel lines; false where it
// leaves the image.
bool ReadProfile(const cv::Mat& grey, const Eigen::Vector2d& px, const Eigen::Vector2d& step_px,
                 EdgeProfile* profile) {
  const Eigen::Vector2d across = Eigen::Vector2d(step_px.y(), step_px.x()).normalized();
  const double margin = kReach + 1;
  for (const double sign : {-1.0, 1.0}) {
    const Eigen::Vector2d end = px + sign * (margin * step_px + across);
    if (end.x() < 0.0 || end.y() < 0.0 || end.x() >= grey.cols - 1 || end.y() >= grey.rows - 1) {
      return false;
    }
  }
  std::array<float, 2 * kReach + 3> level{};
  for (int i = 0; i < static_cast<int>(level.size()); ++i) {
    for (int line = -1; line <= 1; ++line) {
      const Eigen::Vector2d p = px + (i - kReach - 1) * step_px + line * across;
      level[static_cast<size_t>(i)] += Level(grey, p.x(), p.y()) / 3.0f;
    }
  }
  Samples gradient;
  float mean = 0.0f;
  for (size_t i = 0; i < gradient.size(); ++i) {
    gradient[i] = 0.5f * std::abs(level[i + 2] - level[i]);
    mean += gradient[i] / static_cast<float>(gradient.size());
  }
  for (float& g : gradient) g = (g - mean) / (mean + static_cast<float>(kNoise_levels));
  profile->fine = Smooth(gradient, EdgeProfile::kFine_samples);
  profile->coarse = Smooth(gradient, kCoarse_samples);
  return true;
}

struct Outline {
  Eigen::Vector3d p_lidar;
  bool is_upright;
  double outward;  // +1: the background is to the right, or below
  int row;         // of the range image
};

// Outlines between a cell of the range image and its neighbour, with a third cell on the other side
// of the first.
class OutlineFinder {
 public:
  OutlineFinder(const SegmentedScan& scan, const std::vector<Eigen::Vector3f>& points,
                const Rigid3d& T_cam_lidar)
      : scan_(scan), points_(points), forward_(T_cam_lidar.R().row(2).cast<float>()) {}

  std::vector<Outline> Find() {
    const RangeImage& image = scan_.image;
    for (int row = 0; row < image.rows; ++row) {
      row_ = row;
      for (int column = 1; column + 1 < image.columns; ++column) {
        const int32_t i = image.point[image.Index(row, column)];
        if (i == RangeImage::kNoPoint || scan_.label[static_cast<size_t>(i)] == kLabelGround) {
          continue;
        }
        if (forward_.dot(points_[static_cast<size_t>(i)]) < kNearest_m) continue;
        const int32_t left = image.point[image.Index(row, column - 1)];
        const int32_t right = image.point[image.Index(row, column + 1)];
        Check(i, right, left, true, 1.0);
        Check(i, left, right, true, -1.0);
        if (row == 0 || row + 1 == image.rows) continue;
        Check(i, image.point[image.Index(row - 1, column)],
              image.point[image.Index(row + 1, column)], false, -1.0);
      }
    }
    return std::move(found_);
  }

 private:
  void Check(int32_t near, int32_t beyond, int32_t behind, bool is_upright, double outward) {
    if (beyond == RangeImage::kNoPoint || behind == RangeImage::kNoPoint) return;
    const Eigen::Vector3f& p = points_[static_cast<size_t>(near)];
    const Eigen::Vector3f& p_beyond = points_[static_cast<size_t>(beyond)];
    const float range = p.norm(), range_beyond = p_beyond.norm();
    if (range_beyond - range < std::max(kJump_m, kJumpShare * range)) return;
    const float range_behind = points_[static_cast<size_t>(behind)].norm();
    if (std::abs(range_behind - range) > std::max(kSmooth_m, kSmoothShare * range)) return;
    const Eigen::Vector3f between = (p / range + p_beyond / range_beyond).normalized();
    found_.push_back({(range * between).cast<double>(), is_upright, outward, row_});
  }

  const SegmentedScan& scan_;
  const std::vector<Eigen::Vector3f>& points_;
  Eigen::Vector3f forward_;
  int row_ = 0;
  std::vector<Outline> found_;
};

// Of an image point on the normalised plane, in samples. `velocity_cam` is that of the vehicle as
// the camera feels it (rad/s, m/s, camera axes): an image that is late shows what a camera farther
// along its way sees.
Eigen::Matrix<double, 1, 8> Derivative(const Eigen::Vector3d& p_cam, const Outline& outline,
                                       const Vector6d& velocity_cam) {
  const double z = p_cam.z(), x = p_cam.x() / z, y = p_cam.y() / z;
  RowVector6d by_camera;
  if (outline.is_upright) {
    by_camera << -x * y, 1.0 + x * x, -y, 1.0 / z, 0.0, -x / z;
  } else {
    by_camera << -(1.0 + y * y), x * y, x, 0.0, 1.0 / z, -y / z;
  }
  Eigen::Matrix<double, 1, 8> J;
  J << by_camera, -outline.outward, -by_camera.dot(velocity_cam.transpose());
  return J / kStep_rad;
}

}  // namespace

EdgeProfiles FindEdgeProfiles(const cv::Mat& grey, const SegmentedScan& scan,
                              const std::vector<Eigen::Vector3f>& points_lidar,
                              const Camera& camera, const Rigid3d& T_cam_lidar,
                              const Vector6d& velocity_lidar, int max_edges) {
  EdgeProfiles out;
  out.turning_rad_s = velocity_lidar.head<3>().norm();
  const Vector6d velocity_cam = T_cam_lidar.Adjoint() * velocity_lidar;
  if (grey.empty() || scan.image.rows == 0) return out;
  std::vector<Outline> outlines = OutlineFinder(scan, points_lidar, T_cam_lidar).Find();
  for (const Outline& outline : outlines) {
    const Eigen::Vector3d p_cam = T_cam_lidar * outline.p_lidar;
    // Far to the side nothing is in the image, and distortion turns back.
    if (p_cam.z() < kNearest_m || p_cam.head<2>().norm() > 2.0 * p_cam.z()) continue;
    const Eigen::Vector2d px = camera.Project(p_cam.hnormalized());
    const Eigen::Vector2d step_px = outline.is_upright
                                        ? Eigen::Vector2d(camera.fx_px * kStep_rad, 0.0)
                                        : Eigen::Vector2d(0.0, camera.fy_px * kStep_rad);
    EdgeProfile profile;
    if (!ReadProfile(grey, px, step_px, &profile)) continue;
    profile.is_upright = outline.is_upright;
    profile.J = Derivative(p_cam, outline, velocity_cam);
    profile.group = outline.is_upright ? static_cast<int>(px.x() / kGroup_px) : -1 - outline.row;
    out.profiles.push_back(profile);
  }
  // Evenly thinned: neighbours in a row of the scan see the same.
  const size_t limit = static_cast<size_t>(max_edges);
  if (out.profiles.size() > limit) {
    for (size_t i = 0; i < limit; ++i) {
      out.profiles[i] = out.profiles[i * out.profiles.size() / limit];
    }
    out.profiles.resize(limit);
  }
  std::stable_sort(out.profiles.begin(), out.profiles.end(),
                   [](const EdgeProfile& a, const EdgeProfile& b) { return a.group < b.group; });
  return out;
}

}  // namespace tvl
