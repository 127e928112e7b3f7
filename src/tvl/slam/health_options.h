// When a pose is doubted and when it is given up, see health.h.
#pragma once

namespace tvl {

struct HealthOptions {
  int window_frames = 30;  // over which the usual fit is taken: three seconds
  // Mean misfit (MapFit::mean, 0..1) before anything is known of the surroundings.
  double first_usual_misfit = 0.2;
  // A misfit this much above the usual one asks for other hypotheses of the motion ...
  double suspicious_rise = 0.06;
  // ... and one this much above it is no pose at all, whatever the hypothesis.
  double lost_rise = 0.2;
  // Distance from the expected pose that asks for other hypotheses: six times a hard braking.
  double suspicious_innovation_m = 0.3;
  double suspicious_innovation_rad = 0.05;
  // Fewer judged points say nothing of the fit: the plain, a tunnel's mouth.
  int min_judged = 60;
  // A hypothesis replaces a more probable one if it lies better by this many standard errors.
  double min_better_sigmas = 3.0;
  void Check() const;
};

}  // namespace tvl
