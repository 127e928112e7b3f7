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

void Reserve(size_t points, SegmentedScan* scan) {
  scan->points.clear(), scan->intensity.clear(), scan->time_offset_s.clear();
  scan->ring.clear();
  scan->points.reserve(points), scan->intensity.reserve(points);
  scan->time_offset_s.reserve(points), scan->ring.reserve(points);
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

  SegmentedScan& result = out.scan;
  Reserve(scan.size(), &result);
  const float cosine = static_cast<float>(std::cos(model.vertical_correction_rad));
  const float sine = static_cast<float>(std::sin(model.vertical_correction_rad));
  const bool own_times = !scan.time_offset_s.empty() && deskew != Deskew::kNone;
  for (size_t cell = 0; cell < cells; ++cell) {
    if (image.point[cell] == RangeImage::kNoPoint) continue;
    const size_t i = static_cast<size_t>(image.point[cell]);
    image.point[cell] = static_cast<int32_t>(result.points.size());
    result.points.push_back(Raise(scan.points[i], cosine, sine));
    result.intensity.push_back(scan.intensity.empty() ? 0.0f : scan.intensity[i]);
    result.time_offset_s.push_back(
        own_times ? scan.time_offset_s[i]
                  : TimeOffset_s(geometry.azimuth_rad[i], deskew, model.sweep_s));
    result.ring.push_back(rings.row[i]);
  }
  result.label.assign(result.points.size(), kLabelOutlier);
  result.clusters = 0;
  return out;
}

}  // namespace tvl
