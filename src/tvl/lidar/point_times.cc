#include "tvl/lidar/point_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tvl/lidar/beam_elevations.h"

namespace tvl {
namespace {

struct Span {
  double first = std::numeric_limits<double>::infinity();
  double last = -std::numeric_limits<double>::infinity();
  double Length() const { return last - first; }
};

Span TimesOf(const RawScan& scan, float min_range) {
  Span span;
  for (size_t i = 0; i < scan.size(); ++i) {
    if (!IsReturn(scan.points[i], min_range)) continue;
    span.first = std::min(span.first, scan.time[i]);
    span.last = std::max(span.last, scan.time[i]);
  }
  return span;
}

struct Unit {
  const char* name;
  double seconds;
};
constexpr std::array<Unit, 4> kUnits = {
    {{"s", 1.0}, {"ms", 1e-3}, {"microseconds", 1e-6}, {"ns", 1e-9}}};

// The unit in which all spans are those of a sweep; null if there is none.
const Unit* UnitOf(const std::vector<Span>& spans) {
  constexpr double kShortest_s = 0.005, kLongest_s = 0.6;
  for (const Unit& unit : kUnits) {
    const bool fits = std::all_of(spans.begin(), spans.end(), [&](const Span& span) {
      const double length_s = span.Length() * unit.seconds;
      return length_s > kShortest_s && length_s < kLongest_s;
    });
    if (fits) return &unit;
  }
  return nullptr;
}

}  // namespace

PointTimeMeaning RecogniseTimes(const std::vector<const RawScan*>& scans,
                                const std::vector<Timestamp>& stamps, float min_range) {
  PointTimeMeaning out;
  std::vector<Span> spans;
  for (const RawScan* scan : scans) {
    if (scan->time.empty()) return out;
    spans.push_back(TimesOf(*scan, min_range));
  }
  if (spans.empty()) return out;
  const std::string field = "field '" + scans.front()->time_field + "'";
  const Unit* unit = UnitOf(spans);
  if (unit == nullptr) {
    out.text = field + " is not used: it spans " + std::to_string(spans.front().Length()) +
               " in the first scan, which is no sweep in s, ms, microseconds or ns";
    return out;
  }
  out.s_per_unit = unit->seconds;
  // An offset lies within a sweep or two of its stamp, other clocks began long before.
  constexpr double kOffset_s = 1.0;
  bool is_offset = true, is_absolute = true;
  for (size_t i = 0; i < spans.size(); ++i) {
    const double first_s = spans[i].first * unit->seconds, last_s = spans[i].last * unit->seconds;
    is_offset = is_offset && std::abs(first_s) < kOffset_s && std::abs(last_s) < kOffset_s;
    is_absolute = is_absolute && std::abs(first_s - stamps[i].seconds()) < kOffset_s;
  }
  // Where stamps count from 0 too, the first scans' times are both: offsets are then what is meant
  // if every scan begins at the same value.
  if (is_offset && is_absolute && spans.size() > 1) {
    const double moved_s = (spans.back().first - spans.front().first) * unit->seconds;
    is_offset = moved_s < 0.5 * SecondsBetween(stamps.front(), stamps.back());
  }
  out.times = is_offset     ? PointTimes::kAfterStamp
              : is_absolute ? PointTimes::kAbsolute
                            : PointTimes::kOwnClock;
  out.text = field + " gives the times of the points, in " + unit->name +
             (is_offset     ? " after the stamp"
              : is_absolute ? " as the stamps count them"
                            : " of a clock of its own: the first is taken to be the stamp");
  return out;
}

}  // namespace tvl
