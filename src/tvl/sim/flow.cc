#include "tvl/sim/flow.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

constexpr double kTick_s = 0.05;

// Each value averaged with its neighbours up to `reach` away: no jerks.
std::vector<double> RunningMean(const std::vector<double>& values, int reach) {
  const auto n = static_cast<int>(values.size());
  std::vector<double> smooth;
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    for (int k = i - reach; k <= i + reach; ++k) {
      sum += values[static_cast<size_t>(std::clamp(k, 0, n - 1))];
    }
    smooth.push_back(sum / (2 * reach + 1));
  }
  return smooth;
}

// Appends speeds from that of the last one to `to_m_s`.
void ChangeSpeed(double to_m_s, double rate_m_s2, std::vector<double>* speed) {
  const double from = speed->back();
  const auto steps = static_cast<int>(std::ceil(std::abs(to_m_s - from) / (rate_m_s2 * kTick_s)));
  for (int i = 1; i <= steps; ++i) speed->push_back(from + (to_m_s - from) * i / steps);
}

void HoldSpeed(double time_s, std::vector<double>* speed) {
  speed->insert(speed->end(), static_cast<size_t>(time_s / kTick_s), speed->back());
}

}  // namespace

Flow::Flow(double speed_m_s)
    : way_m_({0.0, speed_m_s}), begin_s_(0.0), interval_s_(1.0), is_endless_(true) {}

Flow::Flow(const std::vector<double>& speed_m_s, double begin_s, double interval_s)
    : begin_s_(begin_s), interval_s_(interval_s), is_endless_(false) {
  TVL_CHECK(speed_m_s.size() >= 2 && interval_s > 0.0) << "a flow needs two instants";
  way_m_.push_back(0.0);
  for (size_t i = 1; i < speed_m_s.size(); ++i) {
    way_m_.push_back(way_m_.back() + 0.5 * interval_s * (speed_m_s[i - 1] + speed_m_s[i]));
  }
  zero_m_ = Integral_m(0.0);
}

double Flow::Integral_m(double time_s) const {
  const double last = static_cast<double>(way_m_.size()) - 1.0;
  double f = (time_s - begin_s_) / interval_s_;
  if (!is_endless_) f = std::clamp(f, 0.0, last);
  const auto i = static_cast<size_t>(std::clamp(std::floor(f), 0.0, last - 1.0));
  return way_m_[i] + (f - static_cast<double>(i)) * (way_m_[i + 1] - way_m_[i]);
}

double Flow::Speed_m_s(double time_s) const {
  return (Way_m(time_s + 0.05) - Way_m(time_s - 0.05)) / 0.1;
}

Flow StopAndGo(const StopAndGoOptions& o, double begin_s, double end_s, Rng* rng) {
  std::vector<double> speed = {0.0};
  while (static_cast<double>(speed.size()) * kTick_s < end_s - begin_s) {
    HoldSpeed(rng->Uniform(o.stand_low_s, o.stand_high_s), &speed);
    // One roll, or two at different speeds.
    const int rolls = rng->Uniform() < 0.4 ? 2 : 1;
    for (int i = 0; i < rolls; ++i) {
      const double to = rng->Uniform(o.low_m_s, o.high_m_s);
      ChangeSpeed(to, to > speed.back() ? o.acceleration_m_s2 : o.braking_m_s2, &speed);
      HoldSpeed(rng->Uniform(o.roll_low_s, o.roll_high_s), &speed);
    }
    ChangeSpeed(0.0, o.braking_m_s2, &speed);
  }
  return Flow(RunningMean(RunningMean(speed, 4), 4), begin_s, kTick_s);
}

}  // namespace tvl::sim
