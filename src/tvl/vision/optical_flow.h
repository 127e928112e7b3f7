// Pyramidal Lucas-Kanade optical flow with a forward-backward check (paper 4.1).
#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace tvl {

struct OpticalFlowOptions {
  // Side of the LK window, odd. The paper names none; of 13 to 31 on real drives 17 keeps the most
  // tracks without losing those in traffic (15 is as good on hedges, 21 on cars).
  int window_px = 17;
  int max_level = 3;  // coarsest pyramid level, 1/8: reaches about 100 px of flow
  // Coarsest level where a position is predicted: reaches about 20 px around it.
  int seeded_level = 1;
  // LK stops after so many steps, or at a step below the second: a tenth of what corners are good
  // to. More costs time only on points that are lost anyway.
  int max_iterations = 12;
  double min_step_px = 0.03;
  double max_backward_error_px = 0.5;  // tracked there and back must end this near the start

  void Check() const;  // throws InputError naming the field
};

// An image and its pyramid (with derivatives). Copies are deep: no two share pixels, but for Part.
class ImagePyramid {
 public:
  ImagePyramid() = default;
  ImagePyramid(cv::Mat grey, const OpticalFlowOptions& options);

  // The levels 0..max_level of `area`, which lies in the image and whose corners are multiples of
  // 2^max_level px. It sees the pixels of this pyramid, which must outlive it.
  ImagePyramid Part(const cv::Rect& area, int max_level) const;

  ImagePyramid(const ImagePyramid& other);
  ImagePyramid& operator=(const ImagePyramid& other);
  ImagePyramid(ImagePyramid&&) = default;
  ImagePyramid& operator=(ImagePyramid&&) = default;

  bool empty() const { return grey_.empty(); }
  cv::Size size() const { return grey_.size(); }
  const cv::Mat& grey() const { return grey_; }                   // 8 bit
  const cv::Mat& gradient() const { return levels_[1]; }          // Scharr dx, dy; 16-bit signed
  const std::vector<cv::Mat>& levels() const { return levels_; }  // as OpenCV's LK wants them

 private:
  cv::Mat grey_;
  std::vector<cv::Mat> levels_;
  int window_px_ = 0, max_level_ = 0;
};

enum class FlowStatus { kTracked, kLost, kBackwardMismatch };

struct FlowPoint {
  cv::Point2f px;  // where the point is now; valid for kTracked
  FlowStatus status = FlowStatus::kLost;
};

// Where a point of the previous image is expected in the current one.
struct FlowSeed {
  cv::Point2f px;
  bool predicted = false;  // px is a prediction, good to about 10 px; else the search is a wide one
};

// Follows points_px of `previous` into `current`, one result a point. `seeds` is empty or as long
// as points_px. A predicted point that the short search loses is searched again without its seed.
std::vector<FlowPoint> TrackPoints(const ImagePyramid& previous, const ImagePyramid& current,
                                   const std::vector<cv::Point2f>& points_px,
                                   const std::vector<FlowSeed>& seeds,
                                   const OpticalFlowOptions& options);

}  // namespace tvl
