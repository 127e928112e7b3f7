#include "tvl/report/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core.hpp>

#include "tvl/report/plot_trajectory.h"

namespace tvl {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

// Pixels near a colour: thin lines are smoothed into the paper around them.
cv::Mat MaskOf(const cv::Mat& picture, const cv::Scalar& colour) {
  cv::Mat mask;
  cv::inRange(picture, colour - cv::Scalar::all(70), colour + cv::Scalar::all(70), mask);
  return mask;
}

// Bounding box of the pixels of one colour.
cv::Rect BoxOf(const cv::Mat& picture, const cv::Scalar& colour) {
  std::vector<cv::Point> points;
  cv::findNonZero(MaskOf(picture, colour), points);
  if (points.empty()) return {};
  int left = 1 << 20, right = 0, top = 1 << 20, bottom = 0;
  for (const cv::Point& p : points) {
    if (p.y < 70) continue;  // the legend
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    top = std::min(top, p.y);
    bottom = std::max(bottom, p.y);
  }
  return {cv::Point(left, top), cv::Point(right + 1, bottom + 1)};
}

TEST(RoundTicks, AreOneTwoOrFive) {
  EXPECT_THAT(RoundTicks({0.0, 10.0}, 5), ElementsAre(0, 2, 4, 6, 8, 10));
  EXPECT_THAT(RoundTicks({-3.0, 260.0}, 5), ElementsAre(0, 100, 200));
  EXPECT_THAT(RoundTicks({0.011, 0.034}, 4),
              ElementsAre(DoubleNear(0.02, 1e-12), DoubleNear(0.03, 1e-12)));
  EXPECT_THAT(RoundTicks({-4.9, 5.1}, 2), ElementsAre(0, 5));
}

TEST(DrawPlot, EqualScaleDrawsASquareSquare) {
  const cv::Scalar red(0, 0, 255);
  PlotSeries square{"square", red, {{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 0}}, false};
  PlotOptions options;
  options.equal_scale = true;
  options.width_px = 1200;
  const cv::Rect equal = BoxOf(DrawPlot({square}, options), red);
  EXPECT_NEAR(equal.width, equal.height, 2);
  EXPECT_GT(equal.height, 400);
  options.equal_scale = false;
  const cv::Rect filled = BoxOf(DrawPlot({square}, options), red);
  EXPECT_GT(filled.width, 1.3 * filled.height);
}

TEST(DrawPlot, SurvivesNothingNanAndASinglePoint) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(DrawPlot({}, {}).empty());
  EXPECT_FALSE(DrawPlot({{"nan", {}, {{nan, 1}, {2, 3}}, false}}, {}).empty());
  EXPECT_FALSE(DrawPlot({{"one", {}, {{7, 7}}, true}}, {}).empty());
}

TEST(PlotTrajectory, TopViewHasZUpAndXRight) {
  // 20 m ahead, then 10 m to the right.
  NamedPath path{"path", {}};
  for (int i = 0; i <= 20; ++i) path.poses.push_back(Rigid3d::Translation(0, 0, i));
  for (int i = 1; i <= 10; ++i) path.poses.push_back(Rigid3d::Translation(i, 0, 20));
  const cv::Mat picture = DrawTopView("turn", {{"empty", {}}, path});
  const cv::Scalar colour = SeriesColour(1);
  const cv::Rect all = BoxOf(picture, colour);
  EXPECT_GT(all.height, 1.6 * all.width);
  // The end of the path is at the upper right: its lower right quarter is empty.
  const cv::Mat lower_right = picture(cv::Rect(all.x + all.width / 2, all.y + all.height / 2,
                                               all.width / 3, all.height / 3))
                                  .clone();
  EXPECT_EQ(cv::countNonZero(MaskOf(lower_right, colour)), 0);
  EXPECT_GT(cv::countNonZero(MaskOf(picture, colour)), 100);
}

}  // namespace
}  // namespace tvl
