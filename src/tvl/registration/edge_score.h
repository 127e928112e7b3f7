// How well outlines in the scan lie on edges of the image, as a function of what moves them.
//
// Over hundreds of outlines the gradients on the lines across them add up where the edges are: the
// sum's maximum is looked for, coarsely along an axis of rotation (and the delay of the images),
// then finely in everything that moves outlines (EdgeVector).
#pragma once

#include <vector>

#include "tvl/registration/edge_profiles.h"

namespace tvl {

// An outline beside the point at which the score is looked at: at the increment x it lies
// edge->J * x + offset samples from the middle of its line.
struct PlacedEdge {
  const EdgeProfile* edge;
  double offset;
  int group;  // those of one thing share their errors
};

// Appends the outlines of the image with that number (unique, increasing) which were read `moved`
// away from the point at which the score is looked at. `edges` must outlive `placed`.
void PlaceEdges(const EdgeProfiles& edges, const EdgeVector& moved, int image,
                std::vector<PlacedEdge>* placed);

struct EdgeSearch {
  double rotation_rad = 0.0, delay_s = 0.0;
  bool is_clear = false;  // the score there stands out among those of other rotations
};

// About camera axis 0 (by upper ends) or 1 (by upright ones), within 1.5 deg; the image is late by
// `delay_s`.
EdgeSearch SearchAxis(const std::vector<PlacedEdge>& placed, int axis, double delay_s = 0.0);
// About axis 1 and within +-`max_delay_s` together.
EdgeSearch SearchDelay(const std::vector<PlacedEdge>& placed, double max_delay_s);

// What is known beforehand, independent normal distributions.
struct EdgePrior {
  EdgeVector expected = EdgeVector::Zero(), sigma;
};

struct EdgeFit {
  bool has_converged = false;
  EdgeVector x = EdgeVector::Zero();
  EdgeMatrix covariance = EdgeMatrix::Zero();
};

// From a start within 0.2 deg. The maximum is an M-estimate, and what things have wrong is taken
// to be common to a group.
EdgeFit FitEdges(const std::vector<PlacedEdge>& placed, const EdgePrior& prior,
                 const EdgeVector& start);

}  // namespace tvl
