// Sensor profiles: the geometry of a lidar as a YAML file.
//
//   lidar:
//     name: HDL-64E
//     beam_blocks_deg: [[2.0, -8.33, 32], ...]  # first, last, count: evenly spaced, topmost first
//     beam_elevation_deg: [15, 13, ...]         # or each beam, topmost first; neither: unknown
//     rows: beams                               # or slices: of equal elevation, for lidars whose
//                                               # points do not lie on rings
//     ring_start_azimuth_deg: 0                 # where rings begin in files stored ring after ring
//     columns: 2048                             # of the range image, over 360 degrees
//     sweep_s: 0.1                              # one revolution
//     range_sigma_m: 0.02
//     min_range_m: 2.5
//     max_range_m: 120.0
//     vertical_correction_deg: 0.205            # added to the elevation of every point
//
// Keys that are left out keep the defaults of LidarModel; unknown keys are errors.
#pragma once

#include <string>
#include <vector>

#include "tvl/sensor/lidar_model.h"

namespace tvl {

// The profile `name`: a built-in one (see ProfileNames), or the path of a YAML file.
// Throws InputError naming the file, line and key.
LidarModel LoadProfile(const std::string& name);

// Parses the text of a profile; `source` names it in errors.
LidarModel ParseProfile(const std::string& yaml, const std::string& source);

// The built-in profiles, ascending.
std::vector<std::string> ProfileNames();

}  // namespace tvl
