// What to simulate.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "tvl/sensor/lidar_model.h"
#include "tvl/sim/beam_error_shape.h"
#include "tvl/sim/ground.h"

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
  // open: a plain with few features. jam: creeping among lorries and cars on all sides, each lane
  // at its own pace. passing: standing, while two lorries of 14 m drive past left and right at 5
  // m/s. highway: 200 m with trees and houses, 1150 m with nothing upright within the lidar's range
  // but at its ends, 150 m with trees and houses again; at 25 m/s if no speed is given.
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
  // The vehicle drives at this speed from frame 0 on, along a straight road, m/s, 1..40. 0: as the
  // preset drives; its frame 0 moves at the preset's cruising speed. For presets that HasSpeed().
  double speed_m_s = 0.0;
  // With a speed: frame 0 lies in the middle of a long bend that this speed allows.
  bool is_turning = false;
  // Of highway: what the road is paved with, see RoadSurface.
  RoadSurface road = RoadSurface::kRich;
  // Of tunnel: after the stop in it the vehicle drives this share faster than before it.
  double faster = 0.0;
  // Beams of the lidar: 64 as KITTI's HDL-64E, or 16 (+-15 deg) or 32 (-25..+15 deg). Scans of 16
  // and 32 beams come with rings and times, as with exact_rings.
  int beams = 64;
  // Constant errors of the beams, elevation and range: this many times the usual ones, 0..10, and
  // their shape over the rings.
  double beam_errors = 1.0;
  BeamErrorShape beam_error_shape = BeamErrorShape::kIndependent;
  bool clean = false;      // a sensor without errors, for tests of the ideal case
  bool has_camera = true;  // images cost most of the time
  // Images show the scene this much after the instant scans are compensated to, truth is given for
  // and stamps tell (negative: before), ms, -100..100: for tests of what finds the delay.
  double camera_delay_ms = 0.0;
  bool exact_rings = false;  // deliver LidarScan::ring and times; a KITTI file has none
  // Faults of the recording, see tvl/sensor/faulty_dataset.h; only OpenSimulation makes them.
  std::string faults;
  int threads = 1;  // for the work on one frame; no influence on results

  bool HasRings() const { return exact_rings || beams != 64; }
  // Throws InputError naming the field.
  void Check() const;
};

// Presets that drive around a block and on over the same streets.
bool IsLoopPreset(const std::string& preset);

// The highway's three stretches together, and their lengths.
inline constexpr double kHighwayBefore_m = 200.0, kHighwayBare_m = 1150.0, kHighwayAfter_m = 150.0;
inline constexpr double kHighway_m = kHighwayBefore_m + kHighwayBare_m + kHighwayAfter_m;
double HighwaySpeed_m_s(const SimOptions& options);

// Frames of a preset where none are asked for: 300, or as many as the whole highway takes.
int DefaultFrames(const SimOptions& options);

// "rich", "poor", "wet". Throws InputError.
RoadSurface ParseRoad(const std::string& text);

// "independent", "sine". Throws InputError.
BeamErrorShape ParseBeamErrorShape(const std::string& text);

// Presets whose vehicle can be given a speed.
bool HasSpeed(const std::string& preset);

// True for "sim:..." names.
bool IsSimUri(const std::string& text);

// sim:PRESET?seed=7&frames=1000&raw=ccw&clean=1&trajectory=FILE&tunnel=A:B&open=A:B&night=A:B
// &changes=0.5&lateral=2&camera=0&rings=1&threads=2&beams=16&speed=15&turn=1
// &road=wet&faster=0.4&delay=30&beam_errors=3&beam_error_shape=sine&faults=drop:30-32;renumber.
// Throws InputError naming an unknown key or a bad value.
SimOptions ParseSimUri(const std::string& uri);

// "none", "cw", "ccw". Throws InputError.
Deskew ParseSpin(const std::string& text);

}  // namespace tvl::sim
