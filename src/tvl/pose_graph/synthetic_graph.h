// Pose graphs like those of a drive through a town, with the truth: for tests and benchmarks.
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/map/pose_graph.h"

namespace tvl {

struct SyntheticGraphOptions {
  int poses = 4500;     // one a metre
  int loops = 300;      // true ones, spread over the revisits
  int false_loops = 0;  // between places far from each other
  // Share of the false loops that come in clusters which agree with each other, like a row of
  // identical houses; the others have random transforms.
  double clustered = 0.5;
  int cluster_size = 8;
  double block_m = 120.0;  // streets lie this far apart
  int blocks = 6;          // streets each way
  // Noise of one metre of odometry, white; with it the drift of 100 m is that measured on
  // simulated drives (0.002-0.004 rad, 0.05 m across).
  double odometry_rotation_rad = 2e-4;
  double odometry_translation_m = 0.005;
  double loop_rotation_rad = 0.003;
  double loop_translation_m = 0.05;
  uint64_t seed = 1;

  // Throws InputError naming the field.
  void Check() const;
};

struct SyntheticGraph {
  PoseGraph graph;  // T_world composed from the odometry; loops in the order of their later pose
  std::vector<Rigid3d> truth;       // T_world of every pose
  std::vector<char> is_false_loop;  // of each loop
};

// Throws InputError if the drive has too few revisits for the loops asked for.
SyntheticGraph MakeSyntheticGraph(const SyntheticGraphOptions& options);

// Root mean square distance of the positions after the best rigid motion onto the truth, m.
double AlignedRmse(const std::vector<Rigid3d>& T_world, const std::vector<Rigid3d>& truth);

}  // namespace tvl
