#include "tvl/slam/frame_clock.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// Gaps beyond this many periods say no more than "long": an hour at 10 Hz.
constexpr double kMostPeriods = 36000.0;
// Measurements that the sensor's own period stands for before stamps have shown theirs.
constexpr size_t kPriorMeasurements = 3;

}  // namespace

const char* ToString(StampVerdict verdict) {
  switch (verdict) {
    case StampVerdict::kRegular:
      return "regular";
    case StampVerdict::kGap:
      return "gap";
    case StampVerdict::kIrregular:
      return "irregular";
    case StampVerdict::kNotAdvancing:
      return "not_advancing";
  }
  return "unknown";
}

void FrameClockOptions::Check() const {
  TVL_CHECK_INPUT(regular_share > 0.0 && regular_share < 0.5)
      << "clock.regular_share: must lie between 0 and 0.5, is " << regular_share;
  TVL_CHECK_INPUT(span_frames >= 1) << "clock.span_frames: must be at least 1, is " << span_frames;
  TVL_CHECK_INPUT(window_frames >= 5)
      << "clock.window_frames: must be at least 5, is " << window_frames;
}

FrameClock::FrameClock(double sweep_s, const FrameClockOptions& options)
    : sweep_s_(sweep_s), options_(options) {
  options_.Check();
}

double FrameClock::MedianPeriod_s() const {
  const auto span = static_cast<size_t>(options_.span_frames);
  std::vector<double> periods_s(kPriorMeasurements, sweep_s_);
  for (size_t i = span; i < stamps_.size(); ++i) {
    const double period_s =
        SecondsBetween(stamps_[i - span], stamps_[i]) / static_cast<double>(span);
    if (period_s > 0.0) periods_s.push_back(period_s);
  }
  const auto middle = periods_s.begin() + static_cast<std::ptrdiff_t>(periods_s.size() / 2);
  std::nth_element(periods_s.begin(), middle, periods_s.end());
  return *middle;
}

FrameInterval FrameClock::Advance(Timestamp stamp) {
  FrameInterval interval;
  const double measured_s = MedianPeriod_s();
  // A frame is one turn of the lidar or, where frames were left out regularly, several.
  interval.period_s = sweep_s_ * std::max(1.0, std::round(measured_s / sweep_s_));
  interval.stamp_s = interval.period_s;
  if (!stamps_.empty()) {
    interval.stamp_s = SecondsBetween(stamps_.back(), stamp);
    const double periods = std::min(kMostPeriods, interval.stamp_s / measured_s);
    const double whole = std::max(1.0, std::round(periods));
    interval.nearest_periods = static_cast<int>(whole);
    if (interval.stamp_s <= 0.0) {
      interval.verdict = StampVerdict::kNotAdvancing;
    } else if (std::abs(periods - whole) > options_.regular_share) {
      interval.verdict = StampVerdict::kIrregular;
    } else {
      interval.periods = interval.nearest_periods;
      if (interval.periods > 1) interval.verdict = StampVerdict::kGap;
    }
  }
  stamps_.push_back(stamp);
  const auto most = static_cast<size_t>(options_.window_frames + options_.span_frames);
  if (stamps_.size() > most) stamps_.pop_front();
  return interval;
}

}  // namespace tvl
