#include "tvl/lidar/scan_layout.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/lidar/beam_elevations.h"
#include "tvl/lidar/line_rows.h"
#include "tvl/lidar/ring_alignment.h"
#include "tvl/lidar/ring_recovery.h"
#include "tvl/lidar/scan_geometry.h"
#include "tvl/lidar/stored_order.h"

namespace tvl {
namespace {

// In the unit of the scan: sensors store zeros, or nearly so, where there was no return.
constexpr float kNearest = 0.1F;

using Scans = std::vector<const RawScan*>;

// Median distance of the returns.
double MedianRange(const Scans& scans) {
  std::vector<float> ranges;
  for (const RawScan* scan : scans) {
    for (const Eigen::Vector3f& p : scan->points) {
      if (IsReturn(p, kNearest)) ranges.push_back(p.norm());
    }
  }
  TVL_CHECK_INPUT(!ranges.empty()) << "the first scans have no point with a return";
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return static_cast<double>(*middle);
}

std::vector<std::vector<int>> LinesByRingNumber(const Scans& scans, int* lines) {
  std::vector<std::vector<int>> out;
  *lines = 0;
  for (const RawScan* scan : scans) {
    std::vector<int>& line = out.emplace_back(scan->size(), -1);
    for (size_t i = 0; i < scan->ring.size(); ++i) {
      if (!IsReturn(scan->points[i], kNearest)) continue;
      line[i] = scan->ring[i];
      *lines = std::max(*lines, line[i] + 1);
    }
  }
  return out;
}

std::vector<std::vector<int>> LinesOfOrganised(const Scans& scans, bool columns, int* lines) {
  std::vector<std::vector<int>> out;
  *lines = static_cast<int>(columns ? scans.front()->width : scans.front()->height);
  for (const RawScan* scan : scans) {
    std::vector<int>& line = out.emplace_back(scan->size(), -1);
    for (size_t i = 0; i < scan->size(); ++i) {
      if (!IsReturn(scan->points[i], kNearest)) continue;
      const int index = static_cast<int>(columns ? i % scan->width : i / scan->width);
      if (index < *lines) line[i] = index;
    }
  }
  return out;
}

std::string Degrees(double rad) {
  std::ostringstream out;
  out.precision(3);
  out << RadToDeg(rad) << " deg";
  return out.str();
}

std::string SpanText(const std::vector<double>& elevation_rad) {
  return Degrees(elevation_rad.front()) + " to " + Degrees(elevation_rad.back());
}

// The points with a return, from the topmost ring to the lowest.
LidarScan TopmostFirst(const RawScan& scan, const ScanLayout& layout) {
  LidarScan out;
  out.points.reserve(scan.size());
  const float metres = static_cast<float>(layout.metres_per_unit);
  for (size_t k = 0; k < scan.size(); ++k) {
    const size_t i = layout.lowest_first ? scan.size() - 1 - k : k;
    if (IsReturn(scan.points[i], kNearest)) out.points.push_back(metres * scan.points[i]);
  }
  return out;
}

// The rings of the scan with the most of them, topmost first.
std::vector<LineElevation> MeasureRings(const Scans& scans, const ScanLayout& layout,
                                        double ring_start_rad) {
  LidarModel unknown;
  unknown.ring_start_azimuth_rad = ring_start_rad;
  std::vector<LineElevation> most;
  for (const RawScan* raw : scans) {
    const LidarScan scan = TopmostFirst(*raw, layout);
    const RingAssignment rings =
        RecoverRings(scan, ComputeScanGeometry(scan), unknown, RingRecoveryOptions());
    if (rings.rings_found <= static_cast<int>(most.size())) continue;
    RawScan ordered;
    ordered.points = scan.points;
    most = MeasureLines({&ordered}, {std::vector<int>(rings.row.begin(), rings.row.end())},
                        rings.rings_found);
  }
  return most;
}

std::vector<double> ElevationsOf(const std::vector<LineElevation>& beams) {
  std::vector<double> out;
  for (const LineElevation& beam : beams) {
    // Where rings lie so near that they appear out of order, they are at least not swapped.
    out.push_back(out.empty() ? beam.median_rad : std::min(out.back(), beam.median_rad));
  }
  return out;
}

// Largest rms between the beams of a profile and those measured. Beams of one sensor are off their
// nominal elevations by some tenths of a degree, an HDL-64E's by up to 1; another sensor's by many.
constexpr double kProfileFits_rad = 0.8 * kPi / 180.0;

double ProfileRms_rad(const LidarModel& profile, const std::vector<LineElevation>& beams) {
  if (profile.beam_elevation_rad.empty()) return 0.0;
  std::vector<RingProfile> rings;
  for (const LineElevation& beam : beams) {
    rings.push_back(
        {beam.range * std::cos(beam.median_rad), beam.range * std::sin(beam.median_rad)});
  }
  const RingAlignment alignment = AlignRingsToBeams(rings, profile.beam_elevation_rad);
  return std::hypot(alignment.rms_rad, alignment.offset_rad);
}

struct ProfileFit {
  const LidarModel* profile = nullptr;  // null: none fits
  double rms_rad = kProfileFits_rad;
};

ProfileFit FittingProfile(const std::vector<LidarModel>& profiles,
                          const std::vector<LineElevation>& measured) {
  ProfileFit best;
  for (const LidarModel& profile : profiles) {
    const size_t beams = profile.beam_elevation_rad.size();
    // A file may lack upper rings that saw the sky, not a quarter of them, and a ring or two may
    // have been torn in two.
    if (20 * measured.size() > 21 * beams || 4 * measured.size() < 3 * beams) continue;
    const double rms_rad = ProfileRms_rad(profile, measured);
    if (rms_rad < best.rms_rad) best = {&profile, rms_rad};
  }
  return best;
}

// The profile whose field of view is that of nearly all points; null if there is none.
const LidarModel* ProfileOfView(const std::vector<LidarModel>& profiles, double top_rad,
                                double bottom_rad) {
  for (const LidarModel& profile : profiles) {
    if (profile.beam_elevation_rad.empty()) continue;
    // Beams that start above the sensor's origin appear up to this much higher nearby.
    constexpr double kClose_rad = 2.0 * kPi / 180.0;
    if (std::abs(profile.beam_elevation_rad.front() - top_rad) < kClose_rad &&
        std::abs(profile.beam_elevation_rad.back() - bottom_rad) < kClose_rad) {
      return &profile;
    }
  }
  return nullptr;
}

// Finds the order of the points, one way after the other; what is found goes into `out`.
class OrderFinder {
 public:
  OrderFinder(const Scans& scans, const LayoutHints& hints, ScanLayout* out)
      : scans_(scans), hints_(hints), out_(*out) {}

  void Find() {
    if (TryRingNumbers() || TryOrganised() || TryRingAfterRing() || TryElevations()) return;
    UseSlices();
  }

 private:
  bool TryRingNumbers() {
    for (const RawScan* scan : scans_) {
      if (scan->ring.empty()) return false;
    }
    int lines = 0;
    const auto line_of = LinesByRingNumber(scans_, &lines);
    std::optional<LineRows> rows = RowsOfLines(scans_, line_of, lines);
    const std::string field = "field '" + scans_.front()->ring_field + "'";
    if (!rows) {
      Note(field + " does not number the beams of a spinning lidar: points of one number lie at " +
           "many elevations, or there are fewer than 4 numbers");
      return false;
    }
    out_.order = ScanOrder::kRingNumbers;
    out_.row_of_line = std::move(rows->row_of_line);
    Note(field + " gives the beam of each point");
    UseBeams(rows->beams);
    return true;
  }

  bool TryOrganised() {
    const size_t width = scans_.front()->width, height = scans_.front()->height;
    if (height < 2 || width < 2) return false;
    for (const RawScan* scan : scans_) {
      if (scan->width != width || scan->height != height) return false;
    }
    for (const bool columns : {false, true}) {
      int lines = 0;
      const auto line_of = LinesOfOrganised(scans_, columns, &lines);
      std::optional<LineRows> rows = RowsOfLines(scans_, line_of, lines);
      if (!rows) continue;
      out_.order = ScanOrder::kOrganised;
      out_.lines_are_columns = columns;
      out_.row_of_line = std::move(rows->row_of_line);
      Note("organised, " + std::to_string(width) + " x " + std::to_string(height) + ": the " +
           (columns ? "columns" : "rows") + " are the beams");
      UseBeams(rows->beams);
      return true;
    }
    return false;
  }

  bool TryRingAfterRing() {
    std::vector<RingOrder> found;
    for (const RawScan* scan : scans_) {
      const std::optional<RingOrder> one = FindRingOrder(*scan, kNearest);
      if (!one) return false;
      if (!found.empty() && one->lowest_first != found.front().lowest_first) return false;
      found.push_back(*one);
    }
    out_.lowest_first = found.front().lowest_first;
    ring_start_rad_ = RingStart_rad(found);
    const std::vector<LineElevation> rings = MeasureRings(scans_, out_, ring_start_rad_);
    out_.order = ScanOrder::kRingAfterRing;
    Note(std::string("stored ring after ring, the ") + (out_.lowest_first ? "lowest" : "topmost") +
         " first, beginning at an azimuth of " + Degrees(ring_start_rad_));
    UseBeams(rings);
    return true;
  }

  bool TryElevations() {
    const std::vector<double> beams_rad = FindElevationClusters(scans_, kNearest);
    if (beams_rad.empty()) return false;
    out_.order = ScanOrder::kElevations;
    Note("not stored ring after ring: the beams are told by their elevations");
    std::vector<LineElevation> beams;
    for (const double elevation_rad : beams_rad) beams.push_back({1, elevation_rad, 20.0, 0.0});
    UseBeams(beams);
    return true;
  }

  void UseSlices();
  void UseBeams(const std::vector<LineElevation>& beams);
  void Note(const std::string& text) { out_.notes.push_back(text); }

  const Scans& scans_;
  const LayoutHints& hints_;
  double ring_start_rad_ = 0.0;
  ScanLayout& out_;
};

void OrderFinder::UseBeams(const std::vector<LineElevation>& beams) {
  const std::vector<double> elevation_rad = ElevationsOf(beams);
  out_.measured_beams = static_cast<int>(elevation_rad.size());
  const std::string measured =
      std::to_string(elevation_rad.size()) + " beams from " + SpanText(elevation_rad);
  if (hints_.is_given_by_user) {
    out_.lidar = hints_.lidar;
    out_.profile_rms_rad = ProfileRms_rad(hints_.lidar, beams);
    if (out_.profile_rms_rad >= kProfileFits_rad) {
      out_.warnings.push_back("profile '" + hints_.lidar.name + "' does not fit the scans, which " +
                              "have " + measured + ": " + Degrees(out_.profile_rms_rad) +
                              " beside its own");
    }
  } else if (const ProfileFit fit = FittingProfile(hints_.profiles, beams); fit.profile) {
    out_.lidar = *fit.profile;
    out_.profile_rms_rad = fit.rms_rad;
    Note(measured + ": those of profile " + fit.profile->name + " to " + Degrees(fit.rms_rad));
  } else {
    out_.lidar = LidarModel();
    out_.lidar.name = std::to_string(elevation_rad.size()) + " beams as measured";
    out_.lidar.beam_elevation_rad = elevation_rad;
    out_.lidar.min_range_m = 1.0;
    out_.lidar.sweep_s = hints_.period_s;
    Note(measured + ", of no sensor there is a profile of: taken as measured");
  }
  // Rows are those of the lines found, and their elevations those of this very sensor. Where rings
  // are found in every scan anew, the profile tells which of them are missing.
  if (out_.order != ScanOrder::kRingAfterRing) out_.lidar.beam_elevation_rad = elevation_rad;
  if (out_.order == ScanOrder::kRingAfterRing && ring_start_rad_ != 0.0) {
    out_.lidar.ring_start_azimuth_rad = ring_start_rad_;
  }
}

// So many slices, unless they would be thinner than a point's footprint.
void OrderFinder::UseSlices() {
  constexpr int kRows = 64;
  constexpr double kThinnest_rad = 0.2 * kPi / 180.0;
  std::vector<float> elevations;
  for (const RawScan* scan : scans_) {
    for (const Eigen::Vector3f& p : scan->points) {
      if (IsReturn(p, kNearest)) elevations.push_back(Elevation_rad(p));
    }
  }
  std::sort(elevations.begin(), elevations.end());
  const auto quantile_rad = [&](double share) {
    return static_cast<double>(
        elevations[static_cast<size_t>(share * static_cast<double>(elevations.size() - 1))]);
  };
  const double bottom_rad = quantile_rad(0.001);
  const double top_rad = std::max(bottom_rad + 4.0 * kThinnest_rad, quantile_rad(0.999));
  const int rows = std::clamp(static_cast<int>((top_rad - bottom_rad) / kThinnest_rad), 4, kRows);
  out_.order = ScanOrder::kSlices;
  const LidarModel* profile =
      hints_.is_given_by_user
          ? &hints_.lidar
          : ProfileOfView(hints_.profiles, quantile_rad(0.99), quantile_rad(0.01));
  if (profile != nullptr) out_.lidar = *profile;
  if (profile == nullptr) out_.lidar.min_range_m = 0.5, out_.lidar.sweep_s = hints_.period_s;
  out_.lidar.name = profile != nullptr ? profile->name + ", beams not told apart" : "no beams";
  out_.lidar.rows_are_beams = false;
  out_.lidar.beam_elevation_rad.clear();
  for (int row = 0; row < rows; ++row) {
    out_.lidar.beam_elevation_rad.push_back(top_rad - (row + 0.5) * (top_rad - bottom_rad) / rows);
  }
  Note("no beams can be told apart: " + std::to_string(rows) + " slices from " +
       SpanText(out_.lidar.beam_elevation_rad));
}

// Of what is stored in the order it was measured, where no times are given.
void FindTimesFromOrder(const Scans& scans, ScanLayout* layout) {
  if (layout->order == ScanOrder::kRingAfterRing) return;
  // Organised clouds whose rows are the beams hold one ring after the other, too.
  if (layout->order == ScanOrder::kOrganised && !layout->lines_are_columns) return;
  bool clockwise = false;
  for (const RawScan* scan : scans) {
    const double turns = StoredTurns(*scan, kNearest);
    if (std::abs(turns) < 0.8 || std::abs(turns) > 1.2) return;
    clockwise = turns < 0.0;
  }
  layout->times = PointTimes::kFromOrder;
  layout->is_clockwise = clockwise;
  layout->notes.push_back(
      std::string("points are stored as they were measured, turning ") +
      (clockwise ? "clockwise" : "counter-clockwise") +
      ": this gives their times within the sweep, whose middle is taken to be the stamp");
}

void FindTimes(const Scans& scans, const std::vector<Timestamp>& stamps, ScanLayout* layout) {
  const PointTimeMeaning meaning = RecogniseTimes(scans, stamps, kNearest);
  if (!meaning.text.empty()) {
    (meaning.times == PointTimes::kNone ? layout->warnings : layout->notes).push_back(meaning.text);
  }
  layout->times = meaning.times;
  layout->s_per_time_unit = meaning.s_per_unit;
  if (meaning.times == PointTimes::kNone) FindTimesFromOrder(scans, layout);
}

void FindIntensity(const Scans& scans, ScanLayout* layout) {
  float highest = 0.0F;
  for (const RawScan* scan : scans) {
    for (const float value : scan->intensity) highest = std::max(highest, value);
  }
  if (highest > 1.5F) layout->intensity_per_unit = highest <= 255.0F ? 1.0 / 255.0 : 1.0 / 65535.0;
}

// Row of each point, -1 for points that have none. Not for kRingAfterRing and kSlices.
class RowFinder {
 public:
  explicit RowFinder(const ScanLayout& layout) : layout_(layout) {
    const std::vector<double>& beams_rad = layout.lidar.beam_elevation_rad;
    for (size_t i = 1; i < beams_rad.size(); ++i) {
      border_.push_back(static_cast<float>(0.5 * (beams_rad[i - 1] + beams_rad[i])));
    }
  }

  int Row(const RawScan& scan, size_t i) const {
    if (layout_.order == ScanOrder::kRingNumbers) return RowOfLine(scan.ring[i]);
    if (layout_.order == ScanOrder::kOrganised) {
      return RowOfLine(layout_.lines_are_columns ? i % scan.width : i / scan.width);
    }
    const float elevation = Elevation_rad(scan.points[i]);
    // Borders fall from the topmost row to the lowest.
    const auto below = std::lower_bound(border_.begin(), border_.end(), elevation,
                                        [](float border, float value) { return border > value; });
    return static_cast<int>(below - border_.begin());
  }

 private:
  int RowOfLine(size_t line) const {
    return line < layout_.row_of_line.size() ? layout_.row_of_line[line] : -1;
  }

  const ScanLayout& layout_;
  std::vector<float> border_;  // between neighbouring rows, rad
};

// Whether the scan has what the layout of its recording needs.
bool FitsLayout(const RawScan& scan, const ScanLayout& layout) {
  if (layout.order == ScanOrder::kRingNumbers) return scan.ring.size() == scan.size();
  return layout.order != ScanOrder::kOrganised || (scan.width > 0 && scan.height > 1);
}

// Seconds after the stamp of each of the points `kept`.
std::vector<float> TimesOf(const RawScan& scan, const std::vector<uint32_t>& kept,
                           const ScanLayout& layout, Timestamp stamp) {
  std::vector<float> out;
  if (layout.times == PointTimes::kFromOrder) {
    return TimesFromOrder(scan, kept, layout.is_clockwise, layout.lidar.sweep_s);
  }
  if (layout.times == PointTimes::kNone || scan.time.size() != scan.size()) return out;
  double zero_s = 0.0;
  if (layout.times == PointTimes::kAbsolute) zero_s = stamp.seconds();
  if (layout.times == PointTimes::kOwnClock && !kept.empty()) {
    double first = scan.time[kept.front()];
    for (const uint32_t i : kept) first = std::min(first, scan.time[i]);
    zero_s = first * layout.s_per_time_unit;
  }
  out.reserve(kept.size());
  for (const uint32_t i : kept) {
    out.push_back(static_cast<float>(scan.time[i] * layout.s_per_time_unit - zero_s));
  }
  return out;
}

}  // namespace

const char* ToString(ScanOrder order) {
  switch (order) {
    case ScanOrder::kRingNumbers:
      return "ring numbers";
    case ScanOrder::kOrganised:
      return "organised";
    case ScanOrder::kRingAfterRing:
      return "ring after ring";
    case ScanOrder::kElevations:
      return "beams by elevation";
    case ScanOrder::kSlices:
      return "no beams";
  }
  return "unknown";
}

ScanLayout RecogniseLayout(const std::vector<ScanSample>& samples, const LayoutHints& hints) {
  Scans scans;
  std::vector<Timestamp> stamps;
  for (const ScanSample& sample : samples) {
    if (sample.scan == nullptr || sample.scan->size() == 0) continue;
    scans.push_back(sample.scan);
    stamps.push_back(sample.stamp);
  }
  ScanLayout layout;
  const double range = MedianRange(scans);
  // No lidar has half of its returns beyond 300 m; in millimetres nearly all have.
  constexpr double kFarthestMedian_m = 300.0;
  if (range > kFarthestMedian_m) {
    layout.metres_per_unit = 1e-3;
    layout.notes.push_back("coordinates are taken to be millimetres: half of the points lie " +
                           std::to_string(static_cast<int>(range)) + " units away and more");
  }
  OrderFinder(scans, hints, &layout).Find();
  FindIntensity(scans, &layout);
  FindTimes(scans, stamps, &layout);
  return layout;
}

LidarScan ApplyLayout(const RawScan& scan, const ScanLayout& layout, Timestamp stamp) {
  const bool has_rows =
      layout.order != ScanOrder::kRingAfterRing && layout.order != ScanOrder::kSlices;
  LidarScan out;
  if (!FitsLayout(scan, layout)) return out;
  const RowFinder rows(layout);
  std::vector<uint32_t> kept;
  kept.reserve(scan.size());
  if (has_rows) out.ring.reserve(scan.size());
  for (size_t k = 0; k < scan.size(); ++k) {
    const size_t i = layout.lowest_first ? scan.size() - 1 - k : k;
    if (!IsReturn(scan.points[i], kNearest)) continue;
    const int row = has_rows ? rows.Row(scan, i) : 0;
    if (row < 0) continue;
    kept.push_back(static_cast<uint32_t>(i));
    if (has_rows) out.ring.push_back(static_cast<uint16_t>(row));
  }
  const float metres = static_cast<float>(layout.metres_per_unit);
  const float intensity = static_cast<float>(layout.intensity_per_unit);
  out.points.reserve(kept.size());
  for (const uint32_t i : kept) out.points.push_back(metres * scan.points[i]);
  if (scan.intensity.size() == scan.size()) {
    out.intensity.reserve(kept.size());
    for (const uint32_t i : kept) out.intensity.push_back(intensity * scan.intensity[i]);
  }
  out.time_offset_s = TimesOf(scan, kept, layout, stamp);
  return out;
}

}  // namespace tvl
