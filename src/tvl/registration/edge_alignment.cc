#include "tvl/registration/edge_alignment.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;
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

// Widths of the smoothing, in samples: the kernel of the fine search (0.12 deg is how far single
// outlines scatter: half a step of the lidar) and of the first one.
constexpr double kFine_samples = 1.6;
constexpr double kCoarse_samples = 4.0;
// Gradients of less than this many grey levels a sample are noise.
constexpr double kNoise_levels = 2.0;

// What is not the rotation: the camera's place, and the width by which things look too large.
constexpr double kPlaceSigma_m = 0.02;
constexpr double kWidthSigma_rad = 9e-4;      // 0.05 deg, half of a beam's divergence
constexpr double kRotationSigma_rad = 0.035;  // 2 deg: the reach
constexpr int kMinEdges = 60;                 // for an answer
// The outlines of one image may all be of one thing, and of one mistake.
constexpr int kMinImages = 4;

// A clear answer: its score stands out so many times the scatter of the scores elsewhere, where the
// best is lower by this factor.
constexpr double kMinContrast = 4.5;
constexpr double kMaxSecond = 0.55;
constexpr double kElsewhere_rad = 0.012;  // 0.7 deg from the best

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
  profile->fine = Smooth(gradient, kFine_samples);
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

// Of an image point on the normalised plane by the camera's rotation and translation, then by the
// width; in samples.
Eigen::Matrix<double, 1, 7> Derivative(const Eigen::Vector3d& p_cam, const Outline& outline) {
  const double z = p_cam.z(), x = p_cam.x() / z, y = p_cam.y() / z;
  Eigen::Matrix<double, 1, 7> J;
  if (outline.is_upright) {
    J << -x * y, 1.0 + x * x, -y, 1.0 / z, 0.0, -x / z, -outline.outward;
  } else {
    J << -(1.0 + y * y), x * y, x, 0.0, 1.0 / z, -y / z, -outline.outward;
  }
  return J / kStep_rad;
}

// Score and its derivatives by the position, in samples.
struct Sample {
  double value = 0.0, slope = 0.0, bend = 0.0;
};

// By a parabola through the three nearest samples: smooth enough between smoothed samples.
Sample At(const Samples& samples, double position) {
  const double s = position + kReach;
  const int i = static_cast<int>(std::lround(s));
  if (i < 1 || i + 1 >= static_cast<int>(samples.size())) return {};
  const double a = s - i;
  const auto at = [&](int k) { return static_cast<double>(samples[static_cast<size_t>(k)]); };
  const double slope = 0.5 * (at(i + 1) - at(i - 1)), bend = at(i + 1) - 2.0 * at(i) + at(i - 1);
  return {at(i) + a * (slope + 0.5 * a * bend), slope + a * bend, bend};
}

// Without what bends upwards: such directions are left to the prior.
Matrix7d NonNegative(const Matrix7d& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix7d> solver(symmetric);
  const Vector7d kept = solver.eigenvalues().cwiseMax(0.0);
  return solver.eigenvectors() * kept.asDiagonal() * solver.eigenvectors().transpose();
}

// One profile beside the rotation it was read with.
struct Placed {
  const EdgeProfile* edge;
  double offset;  // of the position, in samples: - J w of what was known when it was read
  int group;
};

bool IsClear(const std::vector<double>& scores, size_t best) {
  const int apart = static_cast<int>(kElsewhere_rad / kStep_rad);
  double sum = 0.0, squares = 0.0, second = -1e300;
  int count = 0;
  for (int i = 0; i < static_cast<int>(scores.size()); ++i) {
    if (std::abs(i - static_cast<int>(best)) <= apart) continue;
    const double score = scores[static_cast<size_t>(i)];
    sum += score;
    squares += score * score;
    second = std::max(second, score);
    ++count;
  }
  if (count < 10) return false;
  const double mean = sum / count;
  const double sigma = std::sqrt(std::max(0.0, squares / count - mean * mean));
  const double height = scores[best] - mean;
  return height > kMinContrast * sigma && second - mean < kMaxSecond * height;
}

// Along one axis of rotation, near enough that the fine search ends right. False: no clear answer.
bool SearchAxis(const std::vector<Placed>& placed, int axis, double* rotation_rad) {
  constexpr int kSteps = 20;  // 1.5 deg
  std::vector<double> scores;
  for (int i = -kSteps; i <= kSteps; ++i) {
    double score = 0.0;
    for (const Placed& p : placed) {
      if (p.edge->is_upright != (axis == 1)) continue;
      score += At(p.edge->coarse, p.edge->J[axis] * i * kStep_rad + p.offset).value;
    }
    scores.push_back(score);
  }
  const size_t best =
      static_cast<size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  *rotation_rad = (static_cast<int>(best) - kSteps) * kStep_rad;
  return IsClear(scores, best);
}

// The score's maximum is an M-estimate: its covariance is that of the gradients between the
// inverses of the curvature, with those of one thing taken together.
class FineSearch {
 public:
  FineSearch(const std::vector<Placed>& placed, const Vector7d& start)
      : placed_(placed), x_(start) {
    prior_.setZero();
    prior_.diagonal().head<3>().setConstant(std::pow(kRotationSigma_rad, -2));
    prior_.diagonal().segment<3>(3).setConstant(std::pow(kPlaceSigma_m, -2));
    prior_(6, 6) = std::pow(kWidthSigma_rad, -2);
  }

  bool Solve() {
    constexpr int kIterations = 12;
    for (int i = 0; i < kIterations; ++i) {
      if (!Linearize()) return false;
      Vector7d step = H_.ldlt().solve(b_);
      // No farther than the curvature is known.
      const double turn_rad = step.head<3>().norm();
      const double limit_rad = kFine_samples * kStep_rad;
      if (turn_rad > limit_rad) step *= limit_rad / turn_rad;
      x_ += step;
      if (turn_rad < 0.02 * kStep_rad) break;
    }
    return Linearize();
  }

  const Vector7d& x() const { return x_; }
  Eigen::Matrix3d Covariance() const {
    const Matrix7d inverse = H_.inverse();
    return (inverse * (spread_ + prior_) * inverse).topLeftCorner<3, 3>();
  }

 private:
  bool Linearize() {
    Matrix7d curvature = Matrix7d::Zero(), squares = Matrix7d::Zero();
    Vector7d gradient = Vector7d::Zero(), group_gradient = Vector7d::Zero();
    spread_.setZero();
    int group = -1;
    const auto close_group = [&] {
      spread_ += group_gradient * group_gradient.transpose();
      group_gradient.setZero();
    };
    for (const Placed& p : placed_) {
      const Sample sample = At(p.edge->fine, p.edge->J.dot(x_.transpose()) + p.offset);
      if (p.group != group) close_group();
      group = p.group;
      const Vector7d J = p.edge->J.transpose();
      const Matrix7d JJ = J * J.transpose();
      curvature -= sample.bend * JJ;
      squares += sample.slope * sample.slope * JJ;
      gradient += sample.slope * J;
      group_gradient += sample.slope * J;
    }
    close_group();
    // In units in which curvature and squared gradients agree, as of a log likelihood.
    const double scale = curvature.topLeftCorner<2, 2>().trace();
    const double unit = squares.topLeftCorner<2, 2>().trace() / scale;
    if (!(scale > 0.0) || !(unit > 0.0)) return false;
    H_ = prior_ + NonNegative(curvature / unit);
    b_ = gradient / unit - prior_ * x_;
    spread_ /= unit * unit;
    return true;
  }

  const std::vector<Placed>& placed_;
  Vector7d x_, b_;
  Matrix7d prior_, H_, spread_;
};

}  // namespace

void EdgeAlignmentOptions::Check() const {
  TVL_CHECK_INPUT(max_edges >= kMinEdges)
      << "extrinsics.edges.max_edges: must be at least " << kMinEdges;
  TVL_CHECK_INPUT(max_images >= 1) << "extrinsics.edges.max_images: must be at least 1";
  TVL_CHECK_INPUT(min_way_m >= 0.0) << "extrinsics.edges.min_way_m: must not be negative";
  TVL_CHECK_INPUT(every_frames >= 1) << "extrinsics.edges.every_frames: must be at least 1";
  TVL_CHECK_INPUT(bias_across_rad > 0.0) << "extrinsics.edges.bias_across_rad: must be positive";
  TVL_CHECK_INPUT(bias_up_rad > 0.0) << "extrinsics.edges.bias_up_rad: must be positive";
  TVL_CHECK_INPUT(bias_about_rad > 0.0) << "extrinsics.edges.bias_about_rad: must be positive";
}

EdgeProfiles FindEdgeProfiles(const cv::Mat& grey, const SegmentedScan& scan,
                              const std::vector<Eigen::Vector3f>& points_lidar,
                              const Camera& camera, const Rigid3d& T_cam_lidar, int max_edges) {
  EdgeProfiles out;
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
    profile.J = Derivative(p_cam, outline);
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

EdgeAlignment::EdgeAlignment(const EdgeAlignmentOptions& options) : options_(options) {
  options_.Check();
}

bool EdgeAlignment::IsDue(const Rigid3d& T_odom_lidar) {
  constexpr int kSlower = 4;
  ++frames_since_;
  const bool is_full = static_cast<int>(images_.size()) == options_.max_images;
  const double way_m = (T_odom_lidar.t() - T_odom_last_.t()).norm();
  if (has_image_ && (frames_since_ < options_.every_frames * (is_full ? kSlower : 1) ||
                     way_m < options_.min_way_m)) {
    return false;
  }
  has_image_ = true;
  frames_since_ = 0;
  T_odom_last_ = T_odom_lidar;
  return true;
}

void EdgeAlignment::Add(EdgeProfiles edges, const Eigen::Vector3d& rotation_rad) {
  // Read far from where the camera points, a profile lies beside the outline.
  constexpr double kStale_rad = 0.009;  // 0.5 deg
  while (!images_.empty() && (images_.front().rotation_rad - rotation_rad).norm() > kStale_rad) {
    images_.pop_front();
  }
  images_.push_back({std::move(edges), rotation_rad});
  if (static_cast<int>(images_.size()) > options_.max_images) images_.pop_front();

  std::vector<Placed> placed;
  int image = 0;
  for (const Image& read : images_) {
    constexpr int kGroups = 1 << 16;  // of an image at most
    for (const EdgeProfile& edge : read.edges.profiles) {
      const double moved = edge.J.head<3>().dot((rotation_rad - read.rotation_rad).transpose());
      placed.push_back({&edge, moved, image * kGroups + edge.group});
    }
    ++image;
  }
  const bool is_stale = (estimate_.rotation_rad - rotation_rad).norm() > kStale_rad;
  const bool are_few = static_cast<int>(images_.size()) < kMinImages;
  if (are_few || is_stale) estimate_ = {};  // else kept where there is no new answer
  if (are_few || static_cast<int>(placed.size()) < kMinEdges) return;
  // About the rotation in use.
  Vector7d x = Vector7d::Zero();
  const bool up_is_clear = SearchAxis(placed, 0, &x[0]);
  const bool across_is_clear = SearchAxis(placed, 1, &x[1]);
  if (!up_is_clear) x[0] = 0.0;
  if (!across_is_clear) return;
  FineSearch search(placed, x);
  if (!search.Solve()) return;
  Eigen::Matrix3d covariance = search.Covariance();
  covariance(0, 0) += std::pow(options_.bias_up_rad, 2);
  covariance(1, 1) += std::pow(options_.bias_across_rad, 2);
  covariance(2, 2) += std::pow(options_.bias_about_rad, 2);
  if (!up_is_clear) covariance(0, 0) += std::pow(kRotationSigma_rad, 2);
  estimate_.images = static_cast<int>(images_.size());
  estimate_.rotation_rad = rotation_rad + search.x().head<3>();
  estimate_.information = covariance.inverse();
}

}  // namespace tvl
