#include "tvl/slam/frame_clock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"

namespace tvl {
namespace {

constexpr double kSweep_s = 0.1;

// The intervals that a clock makes of these stamps, without that of the first frame.
std::vector<FrameInterval> IntervalsOf(const std::vector<double>& stamps_s) {
  FrameClock clock(kSweep_s, FrameClockOptions());
  std::vector<FrameInterval> intervals;
  for (const double stamp_s : stamps_s) {
    intervals.push_back(clock.Advance(Timestamp::FromSeconds(stamp_s)));
  }
  intervals.erase(intervals.begin());
  return intervals;
}

std::vector<double> Regular(int frames, double period_s = kSweep_s) {
  std::vector<double> stamps_s;
  for (int k = 0; k < frames; ++k) stamps_s.push_back(1.7e9 + k * period_s);
  return stamps_s;
}

int Count(const std::vector<FrameInterval>& intervals, StampVerdict verdict) {
  int count = 0;
  for (const FrameInterval& interval : intervals) count += interval.verdict == verdict ? 1 : 0;
  return count;
}

TEST(FrameClock, RegularStampsAreOnePeriodApart) {
  // Real lidars turn a few per cent slower or faster than they should.
  for (const double period_s : {0.1, 0.1036, 0.097}) {
    for (const FrameInterval& interval : IntervalsOf(Regular(80, period_s))) {
      EXPECT_EQ(interval.verdict, StampVerdict::kRegular);
      EXPECT_EQ(interval.periods, 1);
      EXPECT_DOUBLE_EQ(interval.period_s, kSweep_s);
    }
  }
}

TEST(FrameClock, AStampThatIsLateIsNotBelieved) {
  std::vector<double> stamps_s = Regular(60);
  stamps_s[30] += 0.06;
  const auto intervals = IntervalsOf(stamps_s);
  EXPECT_EQ(intervals[29].verdict, StampVerdict::kIrregular);
  EXPECT_EQ(intervals[30].verdict, StampVerdict::kIrregular);
  EXPECT_EQ(intervals[31].verdict, StampVerdict::kRegular);
  for (const FrameInterval& interval : intervals) EXPECT_EQ(interval.periods, 1);
  EXPECT_EQ(intervals[29].nearest_periods, 2);
}

TEST(FrameClock, MissingScansAreCounted) {
  std::vector<double> stamps_s = Regular(60);
  stamps_s.erase(stamps_s.begin() + 30, stamps_s.begin() + 35);
  const auto intervals = IntervalsOf(stamps_s);
  EXPECT_EQ(intervals[29].verdict, StampVerdict::kGap);
  EXPECT_EQ(intervals[29].periods, 6);
  EXPECT_EQ(Count(intervals, StampVerdict::kRegular), 53);
}

TEST(FrameClock, AJumpOfTheClockDoesNotMoveThePeriod) {
  for (const double step_s : {20.0, 1000.0, -86400.0}) {
    std::vector<double> stamps_s = Regular(90);
    for (size_t k = 40; k < stamps_s.size(); ++k) stamps_s[k] += step_s;
    const auto intervals = IntervalsOf(stamps_s);
    EXPECT_NE(intervals[39].verdict, StampVerdict::kRegular) << step_s;
    for (size_t k = 40; k < intervals.size(); ++k) {
      EXPECT_EQ(intervals[k].verdict, StampVerdict::kRegular) << step_s << " s, frame " << k + 1;
      EXPECT_EQ(intervals[k].periods, 1);
    }
  }
}

TEST(FrameClock, JitterAndRoundingCountOnePeriodAFrameOnAverage) {
  Rng rng(3);
  std::vector<double> jittered = Regular(200), rounded = Regular(200);
  for (double& stamp_s : jittered) stamp_s += 0.02 * rng.Normal();
  for (double& stamp_s : rounded) stamp_s = 0.25 * std::round(stamp_s / 0.25);
  for (const auto& stamps_s : {jittered, rounded}) {
    double periods = 0.0;
    for (const FrameInterval& interval : IntervalsOf(stamps_s)) {
      EXPECT_DOUBLE_EQ(interval.period_s, kSweep_s);
      EXPECT_LE(interval.periods, 3);
      periods += interval.periods;
    }
    EXPECT_NEAR(periods / 199.0, 1.0, 0.2);
  }
}

TEST(FrameClock, StampsThatStandStillCountOnePeriodAFrame) {
  const auto intervals = IntervalsOf(std::vector<double>(50, 12.0));
  EXPECT_EQ(Count(intervals, StampVerdict::kNotAdvancing), 49);
  for (const FrameInterval& interval : intervals) EXPECT_EQ(interval.periods, 1);
}

TEST(FrameClock, EverySecondFrameIsTwoTurnsOfTheLidar) {
  const auto intervals = IntervalsOf(Regular(60, 0.2));
  EXPECT_EQ(intervals.front().periods * intervals.front().period_s, 0.2);
  EXPECT_EQ(intervals.back().verdict, StampVerdict::kRegular);
  EXPECT_EQ(intervals.back().periods, 1);
  EXPECT_DOUBLE_EQ(intervals.back().period_s, 0.2);
}

TEST(FrameClockOptions, NameTheBadField) {
  FrameClockOptions options;
  options.regular_share = 0.5;
  EXPECT_THROW(options.Check(), InputError);
}

}  // namespace
}  // namespace tvl
