// How far vehicles of a lane have come, over time.
#pragma once

#include <vector>

#include "tvl/base/rng.h"

namespace tvl::sim {

// Way of a lane's traffic, m, as a function of time; 0 at time 0. Const and thread-safe.
class Flow {
 public:
  // Constant speed.
  explicit Flow(double speed_m_s);
  // From the speed at each multiple of interval_s from begin_s on. Before and after, it stands.
  Flow(const std::vector<double>& speed_m_s, double begin_s, double interval_s);

  double Way_m(double time_s) const { return Integral_m(time_s) - zero_m_; }
  double Speed_m_s(double time_s) const;

 private:
  double Integral_m(double time_s) const;

  std::vector<double>
      way_m_;  // at multiples of interval_s_ from begin_s_; two for a constant speed
  double begin_s_, interval_s_;
  bool is_endless_;  // goes on beyond both ends
  double zero_m_ = 0.0;
};

// Traffic that creeps: stands, starts, rolls at a low speed, stops again. Times and speeds are
// drawn between the two values given.
struct StopAndGoOptions {
  double low_m_s = 0.8, high_m_s = 3.0;        // of a roll
  double roll_low_s = 2.0, roll_high_s = 6.0;  // at that speed
  double stand_low_s = 1.5, stand_high_s = 4.0;
  double acceleration_m_s2 = 0.9, braking_m_s2 = 1.1;  // of drivers in a jam
};

// Covers [begin_s, end_s].
Flow StopAndGo(const StopAndGoOptions& options, double begin_s, double end_s, Rng* rng);

}  // namespace tvl::sim
