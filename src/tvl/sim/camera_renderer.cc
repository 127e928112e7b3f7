#include "tvl/sim/camera_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl::sim {
namespace {

constexpr int kWidth = RayPacket::kWidth;
constexpr int kBlockColumns = 4;  // a packet covers a block of 4 x 2 pixels
constexpr int kBlockRows = 2;
constexpr float kClip = 1.3F;  // light far beyond white must not decide a mixed pixel
constexpr int kBandRows = 8;   // rows of a parallel task; a multiple of kBlockRows

// Where rays go through the image plane: up to kWidth normalised image points.
struct Aim {
  int count = 0;
  std::array<float, kWidth> x, y;
};

struct Traced {
  float radiance = 0.0F;
  float range_m = 0.0F;  // 0: sky
  uint32_t surface = 0;  // differs where outlines, materials or the sun's light change
};

// Casts packets of rays for one picture.
class Tracer {
 public:
  Tracer(const SceneView& view, const TownTextures& textures, const Lighting& lighting,
         const CameraRenderOptions& options, const Camera& camera, const Rigid3d& T_world_cam)
      : view_(view),
        textures_(textures),
        lighting_(lighting),
        shadows_(options.sun_shadows),
        max_range_m_(static_cast<float>(options.max_range_m)),
        pixel_rad_(static_cast<float>(1.0 / camera.fx_px)),
        R_world_cam_(T_world_cam.R().cast<float>()),
        origin_(T_world_cam.t().cast<float>()) {}

  std::array<Traced, kWidth> Trace(const Aim& aim) const;

 private:
  std::array<bool, kWidth> Sunlit(const HitPacket& hits, int count) const;
  SurfacePoint Footprint(const SceneHit& hit, const Eigen::Vector3f& direction) const;
  Traced Shade(const SceneHit& hit, const Eigen::Vector3f& direction, bool sunlit) const;

  const SceneView& view_;
  const TownTextures& textures_;
  const Lighting& lighting_;
  bool shadows_;
  float max_range_m_, pixel_rad_;
  Eigen::Matrix3f R_world_cam_;
  Eigen::Vector3f origin_;
};

std::array<bool, kWidth> Tracer::Sunlit(const HitPacket& hits, int count) const {
  std::array<bool, kWidth> sunlit{};
  std::array<int, kWidth> lane_of{};
  RayPacket rays;
  for (int i = 0; i < count; ++i) {
    const SceneHit& hit = hits[static_cast<size_t>(i)];
    if (!hit.hit || !lighting_.FacesSun(hit)) continue;
    sunlit[static_cast<size_t>(i)] = true;
    lane_of[static_cast<size_t>(rays.count)] = i;
    const float lift = 0.005F + 2e-4F * hit.range_m;  // off the surface, past rounding
    rays.Set(rays.count, hit.p_world + lift * hit.normal, lighting_.to_sun(), max_range_m_);
  }
  if (!shadows_ || rays.count == 0) return sunlit;
  const uint32_t occluded = view_.Occluded(rays);
  for (int k = 0; k < rays.count; ++k) {
    if ((occluded >> k) & 1U) sunlit[static_cast<size_t>(lane_of[static_cast<size_t>(k)])] = false;
  }
  return sunlit;
}

// The pixel's image on the surface is as long as the surface is oblique. Objects stand upright:
// the turn from world to object about the vertical follows from the two normals.
SurfacePoint Tracer::Footprint(const SceneHit& hit, const Eigen::Vector3f& direction) const {
  const float cosine = direction.dot(hit.normal);
  const float minor = hit.range_m * pixel_rad_;
  Eigen::Vector3f slope = direction - cosine * hit.normal;
  const float norm = slope.norm();
  const float length = minor / std::max(std::abs(cosine), 0.03F);
  slope *= norm > 1e-4F ? length / norm : 0.0F;
  const Eigen::Vector3f& a = hit.normal;
  const Eigen::Vector3f& b = hit.normal_object;
  const float c = a.x() * b.x() + a.y() * b.y();
  const float s = a.x() * b.y() - a.y() * b.x();
  const float h = std::sqrt(c * c + s * s);
  if (h > 1e-4F) {
    slope = {(c * slope.x() - s * slope.y()) / h, (s * slope.x() + c * slope.y()) / h, slope.z()};
  }
  return {hit.material, hit.object, hit.p_object, hit.normal_object, slope, minor};
}

Traced Tracer::Shade(const SceneHit& hit, const Eigen::Vector3f& direction, bool sunlit) const {
  if (!hit.hit) return {lighting_.Sky(direction, textures_), 0.0F, 0};
  const float albedo = textures_.Albedo(Footprint(hit, direction));
  const bool outline_of_light = sunlit && hit.material != Material::kFoliage;
  const uint32_t surface = (hit.object * 64U + static_cast<uint32_t>(hit.material)) * 2U +
                           static_cast<uint32_t>(outline_of_light) + 1U;
  return {lighting_.Surface(hit, direction, albedo, sunlit), hit.range_m, surface};
}

std::array<Traced, kWidth> Tracer::Trace(const Aim& aim) const {
  RayPacket rays;
  std::array<Eigen::Vector3f, kWidth> directions;
  for (int i = 0; i < aim.count; ++i) {
    const auto k = static_cast<size_t>(i);
    directions[k] = (R_world_cam_ * Eigen::Vector3f(aim.x[k], aim.y[k], 1.0F)).normalized();
    rays.Set(i, origin_, directions[k], max_range_m_);
  }
  const HitPacket hits = view_.Intersect(rays);
  const std::array<bool, kWidth> sunlit = Sunlit(hits, aim.count);
  std::array<Traced, kWidth> traced;
  for (size_t k = 0; k < static_cast<size_t>(aim.count); ++k) {
    traced[k] = Shade(hits[k], directions[k], sunlit[k]);
  }
  return traced;
}

// What the first ray of each pixel met.
struct Layers {
  explicit Layers(cv::Size size)
      : radiance(size, CV_32F), range_m(size, CV_32F), surface(size, CV_32S) {}
  cv::Mat radiance, range_m, surface;
};

void TraceBlock(const Tracer& tracer, const cv::Mat& rays, int x0, int y0, Layers& layers) {
  const int columns = std::min(kBlockColumns, rays.cols - x0);
  const int rows = std::min(kBlockRows, rays.rows - y0);
  Aim aim;
  for (int i = 0; i < columns * rows; ++i) {
    const auto& point = rays.at<cv::Vec2f>(y0 + i / columns, x0 + i % columns);
    aim.x[static_cast<size_t>(i)] = point[0];
    aim.y[static_cast<size_t>(i)] = point[1];
  }
  aim.count = columns * rows;
  const auto traced = tracer.Trace(aim);
  for (int i = 0; i < aim.count; ++i) {
    const Traced& t = traced[static_cast<size_t>(i)];
    const int y = y0 + i / columns;
    const int x = x0 + i % columns;
    layers.radiance.at<float>(y, x) = t.radiance;
    layers.range_m.at<float>(y, x) = t.range_m;
    layers.surface.at<int>(y, x) = static_cast<int>(t.surface);
  }
}

// A row of Layers.
struct LayerRow {
  LayerRow(const Layers& layers, int y)
      : radiance(layers.radiance.ptr<float>(y)),
        range_m(layers.range_m.ptr<float>(y)),
        surface(layers.surface.ptr<int>(y)) {}
  const float* radiance;
  const float* range_m;
  const int* surface;
};

// Whether an outline runs between two pixels that would show: in light as well as in surface.
bool Differ(const LayerRow& row0, int x0, const LayerRow& row1, int x1) {
  constexpr float kVisible = 0.03F;
  const float light0 = std::min(row0.radiance[x0], kClip);
  const float light1 = std::min(row1.radiance[x1], kClip);
  if (std::abs(light0 - light1) < kVisible) return false;
  if (row0.surface[x0] != row1.surface[x1]) return true;
  const float a = row0.range_m[x0];
  const float b = row1.range_m[x1];
  return std::abs(a - b) > 0.1F * std::min(a, b);
}

// 1 for the pixels of a row with an outline towards a neighbour, else 0.
std::vector<uint8_t> Outlines(const Layers& layers, int y) {
  const int cols = layers.radiance.cols;
  const LayerRow here(layers, y);
  const LayerRow above(layers, std::max(y - 1, 0));
  const LayerRow below(layers, std::min(y + 1, layers.radiance.rows - 1));
  std::vector<uint8_t> outline(static_cast<size_t>(cols), 0);
  for (int x = 0; x < cols; ++x) {
    const auto i = static_cast<size_t>(x);
    if (x + 1 < cols && Differ(here, x, here, x + 1)) outline[i] = outline[i + 1] = 1;
    if (outline[i] == 0 && (Differ(here, x, above, x) || Differ(here, x, below, x))) outline[i] = 1;
  }
  return outline;
}

// Adds rays to the pixels of a row that lie on an outline and averages.
class RowRefiner {
 public:
  RowRefiner(const Tracer& tracer, const cv::Mat& rays, int samples, float pixel)
      : tracer_(tracer), rays_(rays), samples_(samples), pixel_(pixel) {}

  void Refine(const Layers& layers, int y, cv::Mat& radiance) const {
    const std::vector<uint8_t> outline = Outlines(layers, y);
    const auto* first = layers.radiance.ptr<float>(y);
    auto* out = radiance.ptr<float>(y);
    std::copy(first, first + radiance.cols, out);
    Aim aim;
    std::array<int, kWidth> column{};
    for (int x = 0; x < radiance.cols; ++x) {
      if (outline[static_cast<size_t>(x)] == 0) continue;
      out[x] = std::min(out[x], kClip) / static_cast<float>(samples_ + 1);
      for (int i = 0; i < samples_; ++i) {
        column[static_cast<size_t>(aim.count)] = x;
        Add(y, x, i, aim);
        if (aim.count == kWidth) Flush(aim, column, out);
      }
    }
    Flush(aim, column, out);
  }

 private:
  void Add(int y, int x, int sample, Aim& aim) const {
    const float turn =
        6.2831853F * (static_cast<float>(sample) + 0.3F) / static_cast<float>(samples_);
    const auto& centre = rays_.at<cv::Vec2f>(y, x);
    const auto k = static_cast<size_t>(aim.count++);
    aim.x[k] = centre[0] + 0.36F * pixel_ * std::cos(turn);
    aim.y[k] = centre[1] + 0.36F * pixel_ * std::sin(turn);
  }

  void Flush(Aim& aim, const std::array<int, kWidth>& column, float* out) const {
    if (aim.count == 0) return;
    const auto traced = tracer_.Trace(aim);
    for (size_t k = 0; k < static_cast<size_t>(aim.count); ++k) {
      out[column[k]] += std::min(traced[k].radiance, kClip) / static_cast<float>(samples_ + 1);
    }
    aim.count = 0;
  }

  const Tracer& tracer_;
  const cv::Mat& rays_;
  int samples_;
  float pixel_;
};

cv::Mat PixelRays(const Camera& camera) {
  cv::Mat rays(camera.height_px, camera.width_px, CV_32FC2);
  for (int y = 0; y < rays.rows; ++y) {
    for (int x = 0; x < rays.cols; ++x) {
      const Eigen::Vector2d point = camera.Unproject(Eigen::Vector2d(x, y));
      rays.at<cv::Vec2f>(y, x) = {static_cast<float>(point.x()), static_cast<float>(point.y())};
    }
  }
  return rays;
}

const Camera& Checked(const Camera& camera) {
  TVL_CHECK_INPUT(camera.width_px > 0 && camera.height_px > 0)
      << "sim camera: size " << camera.width_px << " x " << camera.height_px << " is empty";
  TVL_CHECK_INPUT(camera.fx_px > 0.0 && camera.fy_px > 0.0)
      << "sim camera: focal length " << camera.fx_px << ", " << camera.fy_px;
  return camera;
}

FilmOptions Seeded(FilmOptions film, uint64_t seed) {
  film.seed = Rng::Mix(film.seed ^ Rng::Mix(seed));
  return film;
}

}  // namespace

void CameraRenderOptions::Check() const {
  TVL_CHECK_INPUT(max_range_m > 0.0) << "sim camera: max_range_m = " << max_range_m;
  TVL_CHECK_INPUT(edge_samples >= 0 && edge_samples <= 16)
      << "sim camera: edge_samples = " << edge_samples << " is not in [0, 16]";
  lighting.Check();
  film.Check();
}

CameraRenderer::CameraRenderer(const Scene& scene, const Camera& camera,
                               const CameraRenderOptions& options)
    : scene_(scene),
      camera_(Checked(camera)),
      options_(options),
      textures_({Rng::Mix(options.seed), options.has_identical_houses}),
      lighting_(options.lighting),
      film_(Seeded(options.film, options.seed)),
      rays_(PixelRays(camera)) {
  options.Check();
}

cv::Mat CameraRenderer::Render(const CameraShot& shot, const Executor& executor) const {
  const SceneView view = scene_.View(shot.time_s, shot.time_s);
  const Tracer tracer(view, textures_, lighting_, options_, camera_, shot.T_world_cam);
  Layers layers(rays_.size());
  const auto rows = static_cast<size_t>(rays_.rows);
  executor.For(rows, kBandRows, [&](size_t begin, size_t end) {
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); y += kBlockRows) {
      for (int x = 0; x < rays_.cols; x += kBlockColumns) TraceBlock(tracer, rays_, x, y, layers);
    }
  });
  if (options_.edge_samples == 0) {
    return film_.Develop(layers.radiance, shot.frame, shot.night, executor);
  }
  cv::Mat radiance(rays_.size(), CV_32F);
  const RowRefiner refiner(tracer, rays_, options_.edge_samples,
                           static_cast<float>(1.0 / camera_.fx_px));
  executor.For(rows, kBandRows, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) refiner.Refine(layers, static_cast<int>(y), radiance);
  });
  return film_.Develop(radiance, shot.frame, shot.night, executor);
}

}  // namespace tvl::sim
