// A scan as a file or a message has it, before anything is known of the sensor that made it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tvl {

// Structure of arrays, one entry a point in stored order. `intensity`, `ring` and `time` are either
// empty (no such field) or as long as `points`. Nothing is dropped or converted: points may be NaN,
// zero (where there was no return) or in millimetres, and times may be in any unit, counted from
// any instant. lidar/recognition.h finds out what they mean.
struct RawScan {
  std::vector<Eigen::Vector3f> points;  // x, y, z as stored
  std::vector<float> intensity;         // as stored, of any scale
  std::vector<uint16_t> ring;           // as stored: the beam, in an order of the sensor's own
  std::vector<double> time;             // as stored
  // Organised clouds, height > 1: point (row, column) stands at row * width + column. Where
  // height is 1 the order means nothing of its own. width * height = size().
  size_t width = 0, height = 1;
  // Names of the fields the values came from; empty where there is none.
  std::string intensity_field, ring_field, time_field;

  size_t size() const { return points.size(); }
};

}  // namespace tvl
