// Trajectories against the truth: paper Fig. 11 (top view) and Fig. 12 (error along time).
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// Poses of camera 0 (x right, y down, z forward), already in the world they are to be drawn in.
struct NamedPath {
  std::string name;
  std::vector<Rigid3d> poses;
};

// Seen from above, x to the right, z up, at equal scale; a disc where a path begins, a square where
// it ends. The first path is drawn in black: the truth.
cv::Mat DrawTopView(const std::string& title, const std::vector<NamedPath>& paths);

// Height (-y) along the path's own length, where a top view hides what goes wrong.
cv::Mat DrawHeights(const std::string& title, const std::vector<NamedPath>& paths);

struct NamedErrors {
  std::string name;
  std::vector<double> errors_m;  // one a frame
};

// Position errors over the frame number.
cv::Mat DrawErrors(const std::string& title, const std::vector<NamedErrors>& errors);

}  // namespace tvl
