// How much time has passed between two frames, judged from stamps that may be wrong.
//
// A lidar turns at a steady rate, so that between two frames there is a whole number of its
// periods; a stamp says how many, unless it contradicts that rate. Stamps that come late, jitter,
// are rounded, jump or stand still then cost nothing, and scans that are missing are still counted.
#pragma once

#include <deque>

#include "tvl/base/time.h"

namespace tvl {

struct FrameClockOptions {
  // A stamp is believed if it lies within this share of a period of a whole number of periods:
  // real drivers stamp to a tenth of that, a scan lost in between is a whole period.
  double regular_share = 0.25;
  // Periods are measured over so many frames at a time, which makes the jitter and the rounding of
  // single stamps that much smaller ...
  int span_frames = 8;
  // ... and the median of so many measurements is taken, which a jump of the clock does not move.
  int window_frames = 40;
  void Check() const;
};

enum class StampVerdict {
  kRegular,       // one period after the frame before
  kGap,           // a whole number of periods, more than one
  kIrregular,     // between whole numbers of periods: not believed
  kNotAdvancing,  // not after the frame before: not believed
};
const char* ToString(StampVerdict verdict);

struct FrameInterval {
  // Periods of the lidar since the frame before: as the stamps say where they are believed, else 1.
  int periods = 1;
  int nearest_periods = 1;  // what the stamps are nearest to, believed or not; at least 1
  double period_s = 0.1;    // one of them, whole turns of the lidar
  StampVerdict verdict = StampVerdict::kRegular;
  double stamp_s = 0.1;  // what the stamps say has passed
};

class FrameClock {
 public:
  // `sweep_s` is the time of one turn of the lidar: the period until stamps have shown another.
  FrameClock(double sweep_s, const FrameClockOptions& options);

  // Takes the stamp of the next frame. The first frame's interval is one regular period.
  FrameInterval Advance(Timestamp stamp);

 private:
  double MedianPeriod_s() const;

  double sweep_s_;
  FrameClockOptions options_;
  std::deque<Timestamp> stamps_;  // the last window_frames + span_frames
};

}  // namespace tvl
