// What to simulate.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tvl/sensor/lidar_model.h"

namespace tvl::sim {

// Frames [begin, end); empty by default.
struct FrameRange {
  int begin = 0, end = 0;
  bool Contains(int frame) const { return frame >= begin && frame < end; }
  bool IsEmpty() const { return end <= begin; }
};

// "A:B" with 0 <= A < B. Throws InputError naming `field`.
FrameRange ParseFrameRange(const std::string& text, const std::string& field);

struct SimOptions {
  // city: a drive through a town. loop: around a block and on over the same streets. reverse: the
  // same street back in the opposite direction. traffic: city with many moving vehicles.
  // aliasing: parallel streets of identical houses. nightloop: loop, its second lap in the dark.
  // lateloop: only the last 20 frames overlap the start. tunnel: 200 m of featureless tube.
  // open: a plain with few features.
  std::string preset = "city";
  // KITTI poses (3x4 a line, camera 0, 10 Hz) to drive along instead of the preset's own route; the
  // preset still decides what stands beside the road. Empty: the preset's.
  std::string trajectory_file;
  uint64_t seed = 1;  // decides everything that is random
  int frames = 300;   // 0: all of trajectory_file; never more than it has
  // kNone: scans are compensated to the image instant; else the raw points of a scanner that
  // spins that way.
  Deskew raw = Deskew::kNone;
  // Of the parked cars, bins and plants, this share changes between two passes of a place, out of
  // sight: comes, goes, makes room for another; foliage moves. 0..1.
  double changes = 0.0;
  // The passes after the first lead this far to the left of it, m, 0..2.5: loop, nightloop and
  // lateloop on their own routes only. Oncoming cars stay away where they have no room.
  double lateral_m = 0.0;
  FrameRange tunnel, open, night;  // where the drive leads through these, besides the preset's own
  bool clean = false;              // a sensor without errors, for tests of the ideal case
  bool has_camera = true;          // images cost most of the time
  bool exact_rings = false;        // deliver LidarScan::ring and times; a KITTI file has none
  int threads = 1;                 // for the work on one frame; no influence on results

  // Throws InputError naming the field.
  void Check() const;
};

// Presets that drive around a block and on over the same streets.
bool IsLoopPreset(const std::string& preset);

// True for "sim:..." names.
bool IsSimUri(const std::string& text);

// sim:PRESET?seed=7&frames=1000&raw=ccw&clean=1&trajectory=FILE&tunnel=A:B&open=A:B&night=A:B
// &changes=0.5&lateral=2&camera=0&rings=1&threads=2. Throws InputError naming an unknown key or a
// bad value.
SimOptions ParseSimUri(const std::string& uri);

// "none", "cw", "ccw". Throws InputError.
Deskew ParseSpin(const std::string& text);

}  // namespace tvl::sim
