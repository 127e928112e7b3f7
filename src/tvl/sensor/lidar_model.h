// The geometry of a spinning lidar, as data: no number of a particular sensor lives in code.
#pragma once

#include <string>
#include <vector>

namespace tvl {

// How the points of a scan relate to the motion of the sensor during the sweep.
enum class Deskew {
  kNone,              // already compensated to the frame's stamp
  kClockwise,         // raw; azimuth falls with time (seen from above)
  kCounterClockwise,  // raw; azimuth rises with time
};

struct LidarModel {
  std::string name = "none";
  // Elevation of each beam, topmost first. Empty: rings come with the points.
  std::vector<double> beam_elevation_rad;
  // False where the sensor has no beams that go round (a solid-state or non-repetitive lidar, a
  // depth camera, a merged cloud), or where they cannot be told from one another: rows are then
  // slices of equal elevation, whose middles are in beam_elevation_rad. Neighbours in a row need
  // not be neighbours on a surface, so that features are sought in space, and a row has no error of
  // its own.
  bool rows_are_beams = true;
  // Azimuth at which a ring begins where scans are stored ring after ring; KITTI: straight ahead.
  double ring_start_azimuth_rad = 0.0;
  int columns = 2048;           // columns of the range image over 360 degrees
  double sweep_s = 0.1;         // time of a revolution; the stamp is its middle, facing +x
  double range_sigma_m = 0.02;  // noise of a range
  double min_range_m = 1.5, max_range_m = 120.0;
  // Added to the elevation of every point: the stored points lie too low (design: HDL-64E of
  // KITTI, 0.205 deg). Rotates about p x z.
  double vertical_correction_rad = 0.0;

  int rows() const { return static_cast<int>(beam_elevation_rad.size()); }
  // Largest gap between neighbouring beams, rad; 0 without beams.
  double LargestGap_rad() const;
  // Throws InputError naming the field.
  void Check() const;
};

}  // namespace tvl
