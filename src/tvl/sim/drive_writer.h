// Writes a simulated drive in the layout of KITTI odometry.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "tvl/sim/sim_dataset.h"

namespace tvl::sim {

// Makes `folder` with velodyne/%06d.bin, image_0/%06d.png (8 bit grey), calib.txt, times.txt,
// poses.txt (truth of camera 0, the first the identity) and meta.json (what was simulated); with 16
// or 32 beams lidar.yaml, the profile to read it with (rings are lost: files have none).
// `threads` frames are made at a time. `progress` is told how many are finished, one call at a
// time. A file has its final name only when it is complete; the text files come last. Throws
// InputError naming the file that could not be written.
void WriteDrive(const SimDataset& drive, const std::string& folder, int threads,
                const std::function<void(size_t)>& progress);

}  // namespace tvl::sim
