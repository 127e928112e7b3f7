// Laser residuals with known correspondences, summed into normal equations (paper Eq. 5, 6, 8).
#pragma once

#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/factors/point_to_line.h"
#include "tvl/factors/point_to_plane.h"
#include "tvl/optim/pose_solver.h"
#include "tvl/registration/sweep.h"

namespace tvl {

struct PlaneMatch {
  PointToPlane factor;
  double information;   // 1 / sigma^2, 1/m^2
  int bin = 0;          // of the sweep
  uint32_t source = 0;  // index the caller knows the point by
  int beam = -1;        // the laser beam that measured the point; -1: not told
};

struct LineMatch {
  PointToLine factor;
  double information;
  int bin = 0;
};

struct LaserMatches {
  std::vector<PlaneMatch> planes;
  std::vector<LineMatch> lines;
};

// What an error of one beam's elevation, common to all its points, does: its part of the normal
// equations (1/rad^2, 1/rad) and the cross terms with the pose.
struct BeamSum {
  Vector6d cross = Vector6d::Zero();
  double information = 0.0, b = 0.0;
};

// Normal equations and what the statistics of a run want to know.
struct LaserSum {
  NormalEquations normal;
  std::vector<BeamSum> beams;                  // by beam; empty where no match tells its beam
  double plane_sq_m2 = 0.0, line_sq_m2 = 0.0;  // sums of squared residuals
  // Sum of the robust information of all planes: scales the information that noisy normals leak.
  double plane_information = 0.0;
  // The same for rotations: a normal that is off by one radian across would add
  // information (|p|^2 I - p p' - (p x n)(p x n)') of a rotation that the plane does not hold.
  Eigen::Matrix3d plane_lever_m2 = Eigen::Matrix3d::Zero();

  LaserSum& operator+=(const LaserSum& other);
};

// The equations with the beams' elevation errors eliminated, which are independent and have a
// standard deviation of sigma_rad each: many points of one beam are no better evidence than that.
NormalEquations WithBeamErrors(const LaserSum& sum, double sigma_rad);

// At motion T, with a Cauchy kernel of width `kernel_sigmas` on whitened residuals: outliers
// (moving objects, wrong matches) are common among laser matches.
LaserSum Linearize(const LaserMatches& matches, const Rigid3d& T, const SweepBins& bins,
                   double kernel_sigmas, const Executor& executor);

}  // namespace tvl
