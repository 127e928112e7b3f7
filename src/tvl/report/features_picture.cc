#include "tvl/report/features_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/report/canvas.h"
#include "tvl/report/top_view.h"

namespace tvl {
namespace {

constexpr int kWidth_px = 1200, kHeight_px = 800;
const cv::Scalar kSharp(40, 40, 255), kFlat(200, 130, 255), kLessSharp(30, 30, 150),
    kLessFlat(90, 60, 110), kVisual(0, 230, 255);

// F_v in the lidar frame, m.
std::vector<Eigen::Vector3d> VisualPoints(const FeatureTracks& tracks, const VisualDepths& depths,
                                          const Rigid3d& T_lidar_cam) {
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].status != DepthStatus::kOk) continue;
    points.push_back(T_lidar_cam * (depths[i].depth_m * tracks.tracks[i].ray_cam.homogeneous()));
  }
  return points;
}

void DrawOnImage(cv::Mat& canvas, const std::vector<LaserFeature>& features,
                 const Calibration& calibration, const cv::Scalar& colour) {
  for (const LaserFeature& feature : features) {
    const Eigen::Vector3d p_cam = calibration.T_cam_lidar * feature.p_lidar.cast<double>();
    if (p_cam.z() < 0.5) continue;
    const Eigen::Vector2d n = p_cam.hnormalized();
    if (n.cwiseAbs().maxCoeff() > 3.0) continue;  // the distortion model ends somewhere
    cv::circle(canvas, ShiftedPoint(calibration.camera.Project(n)), 2 << kShift, colour, cv::FILLED,
               cv::LINE_AA, kShift);
  }
}

cv::Mat OnImage(const cv::Mat& image, const LaserFeatures& features, const FeatureTracks& tracks,
                const VisualDepths& depths, const Calibration& calibration) {
  cv::Mat canvas = ToCanvas(image, 0.7);
  DrawOnImage(canvas, features.flat, calibration, kFlat);
  DrawOnImage(canvas, features.sharp, calibration, kSharp);
  for (size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].status != DepthStatus::kOk) continue;
    cv::circle(canvas, ShiftedPoint(tracks.tracks[i].px_cam), 3 << kShift, kVisual, cv::FILLED,
               cv::LINE_AA, kShift);
  }
  return canvas;
}

void DrawFromAbove(TopView& view, const std::vector<LaserFeature>& features,
                   const cv::Scalar& colour, int side_px) {
  for (const LaserFeature& f : features) {
    view.Dot(static_cast<double>(f.p_lidar.x()), static_cast<double>(f.p_lidar.y()), colour,
             side_px);
  }
}

// Both as wide as the wider, black beside.
cv::Mat Stack(const cv::Mat& above, const cv::Mat& below) {
  const int width = std::max(above.cols, below.cols);
  const auto padded = [&](const cv::Mat& part) {
    cv::Mat wide;
    const int left = (width - part.cols) / 2;
    cv::copyMakeBorder(part, wide, 0, 0, left, width - part.cols - left, cv::BORDER_CONSTANT);
    return wide;
  };
  cv::Mat result;
  cv::vconcat(padded(above), padded(below), result);
  return result;
}

std::string Caption(const LaserFeatures& f) {
  return "F_s " + std::to_string(f.sharp.size()) + ", F_f " + std::to_string(f.flat.size()) +
         ", F_ls " + std::to_string(f.less_sharp.size()) + ", F_lf " +
         std::to_string(f.less_flat.size());
}

}  // namespace

cv::Mat DrawFeatures(const cv::Mat& image, const LaserFeatures& features,
                     const FeatureTracks& tracks, const VisualDepths& depths,
                     const Calibration& calibration) {
  TVL_CHECK(tracks.tracks.size() == depths.size()) << "one depth a track";
  TopView view({kWidth_px, kHeight_px}, 10.0, {50.0, 60.0}, TopView::Orientation::kForwardUp);
  view.RangeRings(10.0);
  DrawFromAbove(view, features.less_flat, kLessFlat, 2);
  DrawFromAbove(view, features.less_sharp, kLessSharp, 2);
  DrawFromAbove(view, features.flat, kFlat, 3);
  DrawFromAbove(view, features.sharp, kSharp, 3);
  const auto visual = VisualPoints(tracks, depths, calibration.T_cam_lidar.Inverse());
  for (const Eigen::Vector3d& p : visual) view.Dot(p.x(), p.y(), kVisual, 4);
  cv::Mat picture = view.canvas();
  if (!image.empty()) {
    picture = Stack(OnImage(image, features, tracks, depths, calibration), view.canvas());
  }
  return WithLegend(picture, Caption(features),
                    {{kSharp, "F_s sharp"},
                     {kFlat, "F_f flat"},
                     {kLessSharp, "F_ls"},
                     {kLessFlat, "F_lf"},
                     {kVisual, "F_v " + std::to_string(visual.size()) + " visual with depth"}});
}

}  // namespace tvl
