// What a place looks like to the lidar, whatever the heading and the light (beyond the paper:
// revisits in the opposite direction and at night, which its bag of words cannot see).
//
// Idea: seen from above, a place driven through again is the same image, turned and shifted.
//  - The magnitude of the image's Fourier transform does not know about shifts, which is what makes
//    the other lane harmless (a polar image about the sensor changes with every metre).
//  - Turning the image turns its spectrum. Sampled on rings, each ring's own spectrum over the
//  angle
//    has a magnitude that does not know about turns either: the signature, compared by brute force.
//  - The ring spectra of two places, shifted against each other, give the yaw up to half a turn;
//  the
//    images themselves then give the half turn, x and y (lidar_descriptor_match.h).
#pragma once

#include <cstdint>
#include <vector>

#include "tvl/map/keyframe.h"

namespace tvl {

struct LidarDescriptorOptions {
  // Half the width of the image. Beyond it the feature points of a 64-beam scan get sparse.
  double range_m = 40.0;
  // Two to four scan points of a facade at 20 m fall into one cell; 2 x range / cell = 128 cells.
  double cell_m = 0.625;
  // Height above the ground. Below: kerbs and what the ground estimate gets wrong. Parked cars are
  // kept: they move, but tell the houses of a street apart.
  double min_height_m = 0.5;
  double max_height_m = 6.0;
  // The ground is the lowest tenth of the points of each cell of this size, no steeper than the
  // slope.
  double ground_cell_m = 4.0;
  double ground_slope = 0.25;
  // Wavelengths that make up the signature: from streets and house lengths to parked cars.
  double max_wavelength_m = 40.0;
  double min_wavelength_m = 2.5;

  int grid() const;  // cells a side
  // Throws InputError naming the field.
  void Check() const;
};

// A cell with something standing in it. Its centre is ((x + 0.5) cell_m, (y + 0.5) cell_m) in the
// lidar frame, seen from above.
struct PlaceCell {
  int16_t x = 0, y = 0;
  uint8_t layers = 0;  // occupied layers of 0.5 m
  float weight() const;
};

// About 6.7 kB a keyframe (350 cells on a street), kept in memory.
struct LidarDescriptor {
  static constexpr int kRings = 32, kAngles = 64, kHarmonics = 12;
  std::vector<PlaceCell> cells;  // row by row
  float energy = 0.0F;           // of the image with itself, as PlaceMatcher correlates it
  std::vector<int8_t> spectrum;  // kRings x kAngles over half a turn, each ring of one norm
  std::vector<float> signature;  // kRings x kHarmonics, of norm 1 (0 if there are no cells)
};

// Pure function of one scan's feature points, ground included. The lidar's z axis is roughly up.
// Points of several keyframes put together make it worse: moving cars smear, and what lies behind
// is seen before it in one direction of driving and after it in the other. On a drive whose
// revisits are all in reverse the signature alone ranks the right place first for 89 % with one
// keyframe, 84 % with the last 4 m, 45 % with the last 10 m.
LidarDescriptor DescribePlace(const KeyframeCloud& cloud, const LidarDescriptorOptions& options);

// Cosine of two signatures, 0..1.
float SignatureSimilarity(const LidarDescriptor& a, const LidarDescriptor& b);

}  // namespace tvl
