#include "tvl/lidar/range_image.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

// Fills the cells with the index of the nearest scan point each.
RangeImageResult FillCells(const ScanGeometry& geometry, const RingAssignment& rings,
                           const LidarModel& model, RangeImageResult out) {
  RangeImage& image = out.scan.image;
  const float min_range_m = static_cast<float>(model.min_range_m);
  const float max_range_m = static_cast<float>(model.max_range_m);
  const float columns_per_rad = static_cast<float>(image.columns / (2.0 * kPi));
  const float half = 0.5f * static_cast<float>(image.columns);
  const size_t columns = static_cast<size_t>(image.columns);
  for (size_t i = 0; i < geometry.range_m.size(); ++i) {
    const float range_m = geometry.range_m[i];
    if (range_m < min_range_m || range_m > max_range_m) {
      ++(range_m == 0.0f ? out.not_finite : out.out_of_range);
      continue;
    }
    const int column = static_cast<int>(half - geometry.azimuth_rad[i] * columns_per_rad);
    const size_t cell =
        rings.row[i] * columns + static_cast<size_t>(std::clamp(column, 0, image.columns - 1));
    if (image.point[cell] != RangeImage::kNoPoint) {
      ++out.hidden;
      if (range_m >= image.range_m[cell]) continue;
    }
    image.point[cell] = static_cast<int32_t>(i);
    image.range_m[cell] = range_m;
  }
  return out;
}

// p rotated about p x z by an angle: azimuth and range stay, the elevation rises.
inline Eigen::Vector3f Raise(const Eigen::Vector3f& p, float cosine, float sine) {
  const float h = std::sqrt(p.x() * p.x() + p.y() * p.y());
  const float scale = h > 1e-6f ? cosine - sine * p.z() / h : 1.0f;
  return {p.x() * scale, p.y() * scale, p.z() * cosine + h * sine};
}

SegmentedScan Resize(SegmentedScan scan, size_t points) {
  scan.points.resize(points);
  scan.intensity.resize(points);
  scan.time_offset_s.resize(points);
  scan.ring.resize(points);
  scan.label.assign(points, kLabelOutlier);
  scan.clusters = 0;
  return scan;
}

// Takes over the points of the cells in the order of the cells, which then count in that order.
SegmentedScan FillPoints(const LidarScan& scan, const ScanGeometry& geometry,
                         const RingAssignment& rings, const LidarModel& model, Deskew deskew,
                         SegmentedScan out) {
  const float cosine = static_cast<float>(std::cos(model.vertical_correction_rad));
  const float sine = static_cast<float>(std::sin(model.vertical_correction_rad));
  const bool own_times = !scan.time_offset_s.empty() && deskew != Deskew::kNone;
  const float s_per_rad = TimeOffset_s(1.0f, deskew, model.sweep_s);
  size_t next = 0;
  for (int32_t& point : out.image.point) {
    if (point == RangeImage::kNoPoint) continue;
    const size_t i = static_cast<size_t>(point);
    out.points[next] = Raise(scan.points[i], cosine, sine);
    out.intensity[next] = scan.intensity.empty() ? 0.0f : scan.intensity[i];
    out.time_offset_s[next] =
        own_times ? scan.time_offset_s[i] : s_per_rad * geometry.azimuth_rad[i];
    out.ring[next] = rings.row[i];
    point = static_cast<int32_t>(next++);
  }
  TVL_CHECK(next == out.points.size());
  return out;
}

}  // namespace

RangeImageResult BuildRangeImage(const LidarScan& scan, const ScanGeometry& geometry,
                                 const RingAssignment& rings, const LidarModel& model,
                                 Deskew deskew, SegmentedScan reuse) {
  TVL_CHECK(geometry.range_m.size() == scan.size() && rings.row.size() == scan.size());
  RangeImageResult out;
  out.scan = std::move(reuse);
  RangeImage& image = out.scan.image;
  image.rows = rings.rows;
  image.columns = model.columns;
  const size_t cells = image.Index(image.rows, 0);
  image.range_m.assign(cells, 0.0f);
  image.point.assign(cells, RangeImage::kNoPoint);
  out = FillCells(geometry, rings, model, std::move(out));

  const size_t dropped = static_cast<size_t>(out.not_finite + out.out_of_range + out.hidden);
  out.scan = Resize(std::move(out.scan), scan.size() - dropped);
  out.scan = FillPoints(scan, geometry, rings, model, deskew, std::move(out.scan));
  return out;
}

}  // namespace tvl
