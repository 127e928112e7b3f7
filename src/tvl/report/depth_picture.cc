#include "tvl/report/depth_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tvl/base/check.h"
#include "tvl/report/canvas.h"

namespace tvl {
namespace {

constexpr double kFar_m = 50.0;
constexpr double kUncertain = 0.05;  // share of the depth

// Near depths differ more than far ones: the square root spreads them.
cv::Scalar ColourOf(double depth_m) { return NearToFar(std::sqrt(depth_m / kFar_m)); }

void DrawPoints(cv::Mat& canvas, const std::vector<Eigen::Vector3f>& p_lidar, const Camera& camera,
                const Rigid3d& T_cam_lidar) {
  for (const Eigen::Vector3f& p : p_lidar) {
    const Eigen::Vector3d p_cam = T_cam_lidar * p.cast<double>();
    if (p_cam.z() < 0.5) continue;
    const Eigen::Vector2d n = p_cam.hnormalized();
    if (n.cwiseAbs().maxCoeff() > 3.0) continue;  // the distortion model ends somewhere
    const Eigen::Vector2d px = camera.Project(n);
    const int x = static_cast<int>(std::lround(px.x())), y = static_cast<int>(std::lround(px.y()));
    if (x < 0 || y < 0 || x >= canvas.cols || y >= canvas.rows) continue;
    const cv::Scalar c = ColourOf(p_cam.z());
    cv::Vec3b& pixel = canvas.at<cv::Vec3b>(y, x);
    for (int k = 0; k < 3; ++k) pixel[k] = cv::saturate_cast<uchar>(0.4 * pixel[k] + 0.6 * c[k]);
  }
}

std::string Caption(const VisualDepths& depths) {
  const auto count = [&](DepthStatus status) {
    return std::to_string(std::count_if(depths.begin(), depths.end(),
                                        [&](const VisualDepth& d) { return d.status == status; }));
  };
  return count(DepthStatus::kOk) + " of " + std::to_string(depths.size()) +
         " with depth; no points " + count(DepthStatus::kNoPoints) + ", one ring " +
         count(DepthStatus::kOneRing) + ", small " + count(DepthStatus::kSmallTriangle) +
         ", spread " + count(DepthStatus::kSpread) + ", grazing " + count(DepthStatus::kGrazing) +
         ", far " + count(DepthStatus::kTooFar);
}

}  // namespace

cv::Mat DrawDepths(const cv::Mat& image, const FeatureTracks& tracks, const VisualDepths& depths,
                   const std::vector<Eigen::Vector3f>& p_lidar, const Camera& camera,
                   const Rigid3d& T_cam_lidar) {
  TVL_CHECK(tracks.tracks.size() == depths.size()) << "one depth a track";
  const cv::Scalar grey = cv::Scalar::all(170), black = cv::Scalar::all(0);
  cv::Mat canvas = ToCanvas(image, 0.7);
  DrawPoints(canvas, p_lidar, camera, T_cam_lidar);
  for (size_t i = 0; i < depths.size(); ++i) {
    const cv::Point at = ShiftedPoint(tracks.tracks[i].px_cam);
    const VisualDepth& depth = depths[i];
    if (depth.status != DepthStatus::kOk) {
      cv::circle(canvas, at, 3 << kShift, grey, 1, cv::LINE_AA, kShift);
      continue;
    }
    const bool uncertain = depth.sigma_m > kUncertain * depth.depth_m;
    cv::circle(canvas, at, 5 << kShift, uncertain ? black : cv::Scalar::all(255), cv::FILLED,
               cv::LINE_AA, kShift);
    cv::circle(canvas, at, 4 << kShift, ColourOf(depth.depth_m), cv::FILLED, cv::LINE_AA, kShift);
  }
  return WithLegend(canvas, Caption(depths),
                    {{ColourOf(5.0), "5 m"},
                     {ColourOf(12.0), "12 m"},
                     {ColourOf(25.0), "25 m"},
                     {ColourOf(50.0), "50 m"},
                     {grey, "no depth"},
                     {black, "black rim: sigma > 5 %"}});
}

}  // namespace tvl
