#include "tvl/report/segments_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "tvl/report/canvas.h"
#include "tvl/report/top_view.h"

namespace tvl {
namespace {

constexpr int kWidth_px = 1200, kHeight_px = 800, kRow_px = 3;
const cv::Scalar kGround = cv::Scalar::all(235), kOutlier(255, 110, 40);

// Colour of each label, from the size of its cluster (logarithmic: sizes span three decades).
std::vector<cv::Scalar> ColourOfLabels(const SegmentedScan& scan) {
  int32_t labels = kFirstClusterLabel;
  for (const int32_t label : scan.label) labels = std::max(labels, label + 1);
  std::vector<double> size(static_cast<size_t>(labels), 0.0);
  for (const int32_t label : scan.label) ++size[static_cast<size_t>(label)];
  const double largest = *std::max_element(size.begin() + kFirstClusterLabel - 1, size.end());
  std::vector<cv::Scalar> colours(size.size());
  for (size_t label = 0; label < size.size(); ++label) {
    const double share =
        std::log(std::max(1.0, size[label] / 5.0)) / std::log(std::max(2.0, largest / 5.0));
    colours[label] = GreenToRed(share);
  }
  colours[kLabelOutlier] = kOutlier;
  colours[kLabelGround] = kGround;
  return colours;
}

cv::Mat Unrolled(const SegmentedScan& scan, const std::vector<cv::Scalar>& colours) {
  const RangeImage& image = scan.image;
  cv::Mat cells(image.rows, image.columns, CV_8UC3, cv::Scalar::all(0));
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; ++column) {
      const int32_t point = image.point[image.Index(row, column)];
      if (point == RangeImage::kNoPoint) continue;
      const cv::Scalar& c = colours[static_cast<size_t>(scan.label[static_cast<size_t>(point)])];
      cells.at<cv::Vec3b>(row, column) =
          cv::Vec3b(cv::saturate_cast<uchar>(c[0]), cv::saturate_cast<uchar>(c[1]),
                    cv::saturate_cast<uchar>(c[2]));
    }
  }
  cv::Mat strip;
  cv::resize(cells, strip, {kWidth_px, std::max(1, image.rows) * kRow_px}, 0, 0, cv::INTER_NEAREST);
  return strip;
}

std::string Caption(const SegmentedScan& scan) {
  const auto count = [&](int32_t label) {
    return std::to_string(std::count(scan.label.begin(), scan.label.end(), label));
  };
  return std::to_string(scan.size()) + " points: " + count(kLabelGround) + " ground, " +
         count(kLabelOutlier) + " outliers, " + std::to_string(scan.clusters) + " clusters";
}

}  // namespace

cv::Mat DrawSegments(const SegmentedScan& scan) {
  const std::vector<cv::Scalar> colours = ColourOfLabels(scan);
  TopView view({kWidth_px, kHeight_px}, 10.0, {50.0, 60.0}, TopView::Orientation::kForwardUp);
  view.RangeRings(10.0);
  // Ground first: what stands on it must be seen.
  for (const bool ground : {true, false}) {
    for (size_t i = 0; i < scan.size(); ++i) {
      if ((scan.label[i] == kLabelGround) != ground) continue;
      const Eigen::Vector3f& p = scan.points[i];
      view.Dot(static_cast<double>(p.x()), static_cast<double>(p.y()),
               ground ? cv::Scalar(0.55 * kGround) : colours[static_cast<size_t>(scan.label[i])],
               ground ? 1 : 2);
    }
  }
  cv::Mat picture = view.canvas();
  if (scan.image.rows > 0 && scan.image.columns > 0) {
    cv::vconcat(Unrolled(scan, colours), view.canvas(), picture);
  }
  return WithLegend(picture, Caption(scan),
                    {{kGround, "ground"},
                     {GreenToRed(0.0), "small cluster"},
                     {GreenToRed(1.0), "large cluster"},
                     {kOutlier, "outlier"}});
}

}  // namespace tvl
