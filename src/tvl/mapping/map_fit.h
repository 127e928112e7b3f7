// How well a scan lies on the local map at a pose: the evidence for choosing among hypotheses of
// the motion, and for saying that none of them is right.
//
// Only what stands above the ground counts: the ground fits at every pose along a street. A point
// counts as far as the map knows the place, so that driving into the unknown is no misfit.
#pragma once

#include <Eigen/Core>
#include <set>
#include <vector>

#include "tvl/frame/laser_features.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/mapping/local_map.h"

namespace tvl {

struct MapFitOptions {
  // Distance at which a point counts as a full misfit, m: ten times the range noise of common
  // lidars, a third of what a vehicle moves in a frame at 10 m/s.
  double max_distance_m = 0.3;
  // Further points lie on surfaces that the map has seen in few, coarse arcs.
  double max_range_m = 40.0;
  // The map knows a column of 2 m well if it holds so many points for each of its keyframes (ten at
  // most): a tenth of what one scan of 64 beams leaves on a wall 20 m away. With fewer, a point
  // there counts for less.
  double min_column_points = 20.0;
  // A random sample of this size tells shares of 0.03 apart at 95 %; it takes 0.2 ms.
  int max_points = 1000;
  void Check() const;
};

struct MapFit {
  // One entry a sample point, in the order of the sample: cost 0 (on the map) to 1 (off by
  // max_distance_m or more), and weight 0 (the map does not know the place) to 1 (it knows it
  // well).
  std::vector<float> cost, weight;
  std::vector<int32_t> label;  // LaserFeature::label
  double judged = 0.0;  // sum of the weights: so many points where the map knows the place well
  double mean = 1.0;    // weighted mean cost; 1 if no point can be judged
};

// By how many points more the scan lies on the map than off it: sum of weight (1 - 2 cost). What a
// pose has to show for itself beside others elsewhere, where the map knows more or less.
double Evidence(const MapFit& fit);
// The same in standard errors. Neighbouring points share their errors, see Compare.
double EvidenceSigmas(const MapFit& fit, int correlated = 4);

// A point to judge.
struct FitSample {
  uint32_t index;  // of the feature
  int32_t label;   // LaserFeature::label
};

// The features to judge: what is not ground, within range, spread evenly over the scan.
std::vector<FitSample> SampleForFit(const std::vector<LaserFeature>& features,
                                    const MapFitOptions& options);

// `points` are compensated, p_lidar, m. Thread-safe.
MapFit FitToMap(const std::vector<Eigen::Vector3f>& points, const std::vector<FitSample>& sample,
                const LocalMap& map, const Rigid3d& T_odom_lidar, const MapFitOptions& options);

// The fit of the points on things that the map can know: without the clusters that lie off the map
// as a whole, such as a lorry that has come to stand where there was none.
struct KnownFit {
  double judged = 0.0;  // as MapFit
  double mean = 1.0;
  std::set<int32_t> new_clusters;  // labels of the clusters left out
};
KnownFit FitWithoutNewClusters(const MapFit& fit);

// By how much `a` lies better than `b`, from the points judged in both: the mean difference of
// their costs (positive: a is better) and its standard error. Clusters that lie off the map as a
// whole in both say nothing. Neighbouring points share their errors: they count as one in
// `correlated`.
struct FitComparison {
  double better = 0.0, standard_error = 1.0;
  double common = 0.0;  // sum of the smaller weights
};
FitComparison Compare(const MapFit& a, const MapFit& b, int correlated = 4);

}  // namespace tvl
