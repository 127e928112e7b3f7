#include "tvl/report/tracks_picture.h"

#include <opencv2/imgproc.hpp>
#include <string>

#include "tvl/report/canvas.h"

namespace tvl {
namespace {

constexpr int kLongTrack = 20;  // images; red from here on

double Share(int length) { return static_cast<double>(length - 1) / (kLongTrack - 1); }

std::string Caption(const FeatureTracks& tracks) {
  return std::to_string(tracks.tracks.size()) + " tracks: " + std::to_string(tracks.tracked) +
         " kept, " + std::to_string(tracks.added) + " new; lost: flow " +
         std::to_string(tracks.lost_flow) + ", backward " + std::to_string(tracks.lost_backward) +
         ", epipolar " + std::to_string(tracks.lost_epipolar);
}

}  // namespace

cv::Mat DrawTracks(const cv::Mat& image, const FeatureTracks& tracks) {
  const cv::Scalar blue(255, 60, 0);
  cv::Mat canvas = ToCanvas(image);
  for (const FeatureTrack& track : tracks.tracks) {
    cv::line(canvas, ShiftedPoint(track.px_cam),
             ShiftedPoint(2.0 * track.px_cam - track.px_cam_prev), blue, 1, cv::LINE_AA, kShift);
  }
  for (const FeatureTrack& track : tracks.tracks) {
    cv::circle(canvas, ShiftedPoint(track.px_cam), 3 << kShift, GreenToRed(Share(track.length)),
               cv::FILLED, cv::LINE_AA, kShift);
  }
  return WithLegend(canvas, Caption(tracks),
                    {{GreenToRed(0.0), "new"},
                     {GreenToRed(Share(10)), "10 images"},
                     {GreenToRed(1.0), "20 and more"},
                     {blue, "velocity"}});
}

}  // namespace tvl
