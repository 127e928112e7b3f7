// Map files: PCD and PLY, binary little endian, float32 x y z intensity a point.
#pragma once

#include <string>

#include "tvl/map/map_cloud.h"

namespace tvl {

// PCD 0.7, DATA binary, FIELDS x y z intensity: for PCL, Open3D, CloudCompare.
// Writing is atomic. Throws Error if intensity is not as long as points.
void WritePcd(const std::string& path, const MapCloud& cloud);

// PLY 1.0, binary_little_endian; the intensity is the float property `intensity`.
void WritePly(const std::string& path, const MapCloud& cloud);

// Reads files of the kinds written above (x y z and, optionally, intensity, all float32, binary;
// other properties are refused). Throws InputError naming the file.
MapCloud ReadPcd(const std::string& path);
MapCloud ReadPly(const std::string& path);

}  // namespace tvl
