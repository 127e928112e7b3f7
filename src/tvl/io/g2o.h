// Pose graphs as g2o text files: VERTEX_SE3:QUAT and EDGE_SE3:QUAT lines.
//
// The format's error of an edge is [translation, vector part of the quaternion] of
// Z^-1 T_from^-1 T_to: translation first and half the angle. Its information becomes ours, of
// [rotation (rad), translation (m)] = Log of the same, exactly to first order at zero: rotations
// divided by 4, mixed terms by 2. (GTSAM's reader swaps the order but keeps the half angle.)
#pragma once

#include <string>

#include "tvl/map/pose_graph.h"

namespace tvl {

// Poses are renumbered from 0 in the order of their ids. Edges from one pose to the next one become
// odometry, the first of each pair; all others loops. FIX lines, blank lines and comments ('#') are
// skipped. Throws InputError naming file and line for anything else, for unknown or repeated ids,
// and for numbers that are no rotation or no information.
PoseGraph ReadG2o(const std::string& path);

// Poses with their indices as ids, then odometry, then loops; every number reads back to the same
// double. Atomic. Throws InputError naming the path.
void WriteG2o(const std::string& path, const PoseGraph& graph);

}  // namespace tvl
