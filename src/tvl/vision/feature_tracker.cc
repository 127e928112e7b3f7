#include "tvl/vision/feature_tracker.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "tvl/base/check.h"

namespace tvl {
namespace {

cv::Point2f ToCv(const Eigen::Vector2d& px) {
  return {static_cast<float>(px.x()), static_cast<float>(px.y())};
}

Eigen::Vector2d ToEigen(const cv::Point2f& px) { return {px.x, px.y}; }

std::vector<cv::Point2f> Positions(const std::vector<FeatureTrack>& tracks) {
  std::vector<cv::Point2f> px;
  px.reserve(tracks.size());
  for (const FeatureTrack& track : tracks) px.push_back(ToCv(track.px_cam));
  return px;
}

// The prediction of each track, or none.
std::vector<const PixelPrediction*> PredictionsOf(const std::vector<FeatureTrack>& tracks,
                                                  const PixelPredictions& predicted) {
  std::vector<const PixelPrediction*> found(tracks.size(), nullptr);
  auto next = predicted.pixels.begin();
  for (size_t i = 0; i < tracks.size(); ++i) {
    while (next != predicted.pixels.end() && next->id < tracks[i].id) ++next;
    if (next != predicted.pixels.end() && next->id == tracks[i].id) found[i] = &*next;
  }
  return found;
}

// One seed a track: its prediction, else a step as long as its last.
std::vector<FlowSeed> MakeSeeds(const std::vector<FeatureTrack>& tracks,
                                const std::vector<const PixelPrediction*>& predicted) {
  std::vector<FlowSeed> seeds;
  seeds.reserve(tracks.size());
  for (size_t i = 0; i < tracks.size(); ++i) {
    const bool hit = predicted[i] != nullptr;
    const FeatureTrack& track = tracks[i];
    seeds.push_back(
        {ToCv(hit ? predicted[i]->px_cam : 2.0 * track.px_cam - track.px_cam_prev), hit});
  }
  return seeds;
}

cv::Point2f Map(const cv::Matx33d& H, const cv::Point2f& px) {
  const cv::Vec3d p = H * cv::Vec3d(px.x, px.y, 1.0);
  return {static_cast<float>(p[0] / p[2]), static_cast<float>(p[1] / p[2])};
}

// The part of an image of `size` in which the points are looked for: they may have moved by as much
// as the short search reaches. Its corners fall on pixels of every level.
cv::Rect AreaOf(const std::vector<cv::Point2f>& points_px, cv::Size size,
                const OpticalFlowOptions& options) {
  const int unit = 1 << options.seeded_level, reach = 2 * options.window_px;
  const cv::Rect box = cv::boundingRect(points_px);
  const cv::Point first(std::max(box.x - reach, 0) / unit * unit,
                        std::max(box.y - reach, 0) / unit * unit);
  const cv::Point last(std::min(box.br().x + reach, size.width) / unit * unit,
                       std::min(box.br().y + reach, size.height) / unit * unit);
  return {first, last};
}

// Follows the points that warp, from the previous image as it should look now: fills in what is
// found there, and leaves the rest of `flow` as it is. Only the part of the image with these points
// is warped.
void FollowWarped(const ImagePyramid& previous, const ImagePyramid& current, const cv::Matx33d& H,
                  const std::vector<cv::Point2f>& points_px,
                  const std::vector<const PixelPrediction*>& predicted,
                  const OpticalFlowOptions& options, std::vector<FlowPoint>* flow) {
  const cv::Rect2f image({}, previous.size());
  std::vector<cv::Point2f> warped_px;
  std::vector<size_t> index;
  for (size_t i = 0; i < predicted.size(); ++i) {
    if (predicted[i] == nullptr || !predicted[i]->warps) continue;
    const cv::Point2f px = Map(H, points_px[i]);
    if (!image.contains(px)) continue;  // leaves the image
    warped_px.push_back(px);
    index.push_back(i);
  }
  if (index.empty()) return;
  OpticalFlowOptions near = options;  // the seeds are good: no need to search far
  near.max_level = options.seeded_level;
  const cv::Rect area = AreaOf(warped_px, previous.size(), near);
  const cv::Point2f corner = area.tl();
  std::vector<FlowSeed> seeds;
  for (cv::Point2f& px : warped_px) seeds.push_back({px -= corner, true});
  const cv::Matx33d to_area(1, 0, -area.x, 0, 1, -area.y, 0, 0, 1);
  cv::Mat warped;
  cv::warpPerspective(previous.grey(), warped, to_area * H, area.size(), cv::INTER_LINEAR,
                      cv::BORDER_REPLICATE);
  const std::vector<FlowPoint> found = TrackPoints(
      ImagePyramid(warped, near), current.Part(area, near.max_level), warped_px, seeds, near);
  for (size_t k = 0; k < index.size(); ++k) {
    if (found[k].status != FlowStatus::kTracked) continue;
    (*flow)[index[k]] = {found[k].px + corner, FlowStatus::kTracked};
  }
}

// Follows the points that `flow` does not have yet.
void FollowRest(const ImagePyramid& previous, const ImagePyramid& current,
                const std::vector<cv::Point2f>& points_px, const std::vector<FlowSeed>& seeds,
                const OpticalFlowOptions& options, std::vector<FlowPoint>* flow) {
  std::vector<cv::Point2f> rest_px;
  std::vector<FlowSeed> rest_seeds;
  std::vector<size_t> index;
  for (size_t i = 0; i < points_px.size(); ++i) {
    if ((*flow)[i].status == FlowStatus::kTracked) continue;
    rest_px.push_back(points_px[i]);
    rest_seeds.push_back(seeds[i]);
    index.push_back(i);
  }
  const std::vector<FlowPoint> found = TrackPoints(previous, current, rest_px, rest_seeds, options);
  for (size_t k = 0; k < index.size(); ++k) (*flow)[index[k]] = found[k];
}

// Sets the cells of the mask in which the pixels lie.
void FillCells(const std::vector<Eigen::Vector2f>& pixels, uint8_t value, cv::Mat* mask) {
  constexpr int kCell_px = 16;  // of 64 beams two or three pass through it
  const cv::Rect image(cv::Point(), mask->size());
  for (const Eigen::Vector2f& px : pixels) {
    const cv::Point at(static_cast<int>(px.x()), static_cast<int>(px.y()));
    if (!image.contains(at) || mask->at<uint8_t>(at) == value) continue;
    const cv::Rect cell(at.x / kCell_px * kCell_px, at.y / kCell_px * kCell_px, kCell_px, kCell_px);
    (*mask)(cell & image).setTo(value);
  }
}

// Where nothing but the road is seen.
cv::Mat RoadMask(const RoadView& road, cv::Size size) {
  cv::Mat mask = cv::Mat::zeros(size, CV_8U);
  FillCells(road.road_px, 1, &mask);
  FillCells(road.standing_px, 0, &mask);
  return mask;
}

// Drops the tracks at odds with the epipolar geometry, in place of `result.tracks`.
FeatureTracks FilterEpipolar(FeatureTracks result, const std::vector<Eigen::Vector2d>& rays_prev,
                             const EpipolarFilterOptions& options) {
  std::vector<Eigen::Vector2d> rays;
  rays.reserve(result.tracks.size());
  for (const FeatureTrack& track : result.tracks) rays.push_back(track.ray_cam);
  const std::vector<bool> inlier = EpipolarInliers(rays_prev, rays, options);
  std::vector<FeatureTrack> kept;
  kept.reserve(result.tracks.size());
  for (size_t i = 0; i < inlier.size(); ++i) {
    if (inlier[i]) kept.push_back(result.tracks[i]);
  }
  result.lost_epipolar = static_cast<int>(result.tracks.size() - kept.size());
  result.tracks = std::move(kept);
  return result;
}

}  // namespace

void FeatureTrackerOptions::Check() const {
  TVL_CHECK_INPUT(max_features >= 1) << "max_features: must be at least 1, is " << max_features;
  TVL_CHECK_INPUT(refill_share >= 0.0 && refill_share <= 1.0)
      << "refill_share: must lie in 0..1, is " << refill_share;
  TVL_CHECK_INPUT(road_distance_px >= 1.0)
      << "road_distance_px: must be at least 1, is " << road_distance_px;
  TVL_CHECK_INPUT(min_kept_share >= 0.0 && min_kept_share <= 1.0)
      << "min_kept_share: must lie in 0..1, is " << min_kept_share;
  image.Check();
  flow.Check();
  epipolar.Check();
  corners.Check();
}

FeatureTracker::FeatureTracker(const FeatureTrackerOptions& options) : options_(options) {
  options_.Check();
}

FeatureTracks FeatureTracker::Track(const cv::Mat& image, const Camera& camera,
                                    const PixelPredictions& predicted) {
  if (image.empty()) return Forget();
  const cv::Mat grey = ToGrey8(image);
  if (!IsUsableImage(grey, options_.image)) return Forget();
  ImagePyramid current(Equalise(grey, options_.image), options_.flow);

  FeatureTracks result;
  result.status = TrackingStatus::kFirst;
  if (current.size() == previous_.size()) result = Follow(current, camera, predicted);
  const double wanted = options_.refill_share * options_.max_features;
  if (static_cast<double>(result.tracks.size()) < wanted || result.tracks.empty()) {
    Detect(current, grey, camera, &result);
  }
  if (result.tracks.empty()) return Forget();
  tracks_ = result.tracks;
  previous_ = std::move(current);
  grey_ = grey;
  return result;
}

FeatureTracks FeatureTracker::Follow(const ImagePyramid& current, const Camera& camera,
                                     const PixelPredictions& predicted) const {
  FeatureTracks result;
  std::vector<Eigen::Vector2d> rays_prev;
  const std::vector<const PixelPrediction*> expected = PredictionsOf(tracks_, predicted);
  const std::vector<cv::Point2f> from_px = Positions(tracks_);
  std::vector<FlowPoint> flow(tracks_.size());
  if (predicted.H_cur_prev_ground) {
    FollowWarped(previous_, current, *predicted.H_cur_prev_ground, from_px, expected, options_.flow,
                 &flow);
  }
  FollowRest(previous_, current, from_px, MakeSeeds(tracks_, expected), options_.flow, &flow);
  for (size_t i = 0; i < flow.size(); ++i) {
    result.lost_flow += flow[i].status == FlowStatus::kLost;
    result.lost_backward += flow[i].status == FlowStatus::kBackwardMismatch;
    if (flow[i].status != FlowStatus::kTracked) continue;
    FeatureTrack track = tracks_[i];
    rays_prev.push_back(track.ray_cam);
    track.px_cam_prev = track.px_cam;
    track.px_cam = ToEigen(flow[i].px);
    track.ray_cam = camera.Unproject(track.px_cam);
    ++track.length;
    result.tracks.push_back(track);
  }
  result = FilterEpipolar(std::move(result), rays_prev, options_.epipolar);
  result.status = TrackingStatus::kTracked;
  const double least = options_.min_kept_share * static_cast<double>(tracks_.size());
  if (static_cast<double>(result.tracks.size()) < least || result.tracks.empty()) {
    result.status = TrackingStatus::kLost;
    result.tracks.clear();
  }
  result.tracked = static_cast<int>(result.tracks.size());
  return result;
}

void FeatureTracker::Detect(const ImagePyramid& current, const cv::Mat& grey, const Camera& camera,
                            FeatureTracks* result) {
  CornerSearch search;
  search.count = options_.max_features - static_cast<int>(result->tracks.size());
  search.occupied_px = Positions(result->tracks);
  Add(DetectCorners(current.gradient(), grey, search, options_.corners), camera, result);
}

std::vector<FeatureTrack> FeatureTracker::AddOnRoad(const RoadView& road, int count,
                                                    const Camera& camera) {
  if (grey_.empty() || road.road_px.empty()) return {};
  CornerSearch search;
  search.count = count;
  search.occupied_px = Positions(tracks_);
  search.mask = RoadMask(road, grey_.size());
  CornerDetectorOptions close = options_.corners;
  close.min_distance_px = options_.road_distance_px;
  FeatureTracks added;
  Add(DetectCorners(previous_.gradient(), grey_, search, close), camera, &added);
  tracks_.insert(tracks_.end(), added.tracks.begin(), added.tracks.end());
  return added.tracks;
}

void FeatureTracker::Add(const std::vector<cv::Point2f>& corners_px, const Camera& camera,
                         FeatureTracks* result) {
  for (const cv::Point2f& px : corners_px) {
    FeatureTrack track;
    track.id = next_id_++;
    track.px_cam = track.px_cam_prev = ToEigen(px);
    track.ray_cam = camera.Unproject(track.px_cam);
    result->tracks.push_back(track);
    ++result->added;
  }
}

FeatureTracks FeatureTracker::Forget() {
  previous_ = ImagePyramid();
  grey_.release();
  tracks_.clear();
  return {};
}

FeatureTrackerState FeatureTracker::state() const {
  return {previous_.grey().clone(), tracks_, next_id_};
}

void FeatureTracker::set_state(const FeatureTrackerState& state) {
  previous_ = state.grey.empty() ? ImagePyramid() : ImagePyramid(state.grey.clone(), options_.flow);
  grey_.release();  // AddOnRoad follows a Track
  tracks_ = state.tracks;
  next_id_ = state.next_id;
}

}  // namespace tvl
