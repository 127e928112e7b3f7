// A spinning lidar in the simulated world, with the errors of a real one. Design section 4.10.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "tvl/base/parallel.h"
#include "tvl/base/rng.h"
#include "tvl/geometry/rigid3.h"
#include "tvl/sensor/lidar_model.h"
#include "tvl/sensor/lidar_scan.h"
#include "tvl/sim/beam_error_shape.h"
#include "tvl/sim/scene.h"

namespace tvl::sim {

struct LidarSensorOptions {
  uint64_t seed = 1;            // of the sensor's biases and of its noise
  int columns = 2083;           // firings a revolution: HDL-64E at 10 Hz
  double max_range_m = 80.0;    // the scans of KITTI end there (measured)
  double min_range_m = 1.0;     // nothing nearer is reported
  bool has_errors = true;       // false: exact ranges and angles, no losses, no car in the way
  double range_sigma_m = 0.02;  // data sheet
  double angle_sigma_rad = 3e-4;
  double beam_range_sigma_m = 0.03;  // constant bias of each beam: residual of calibration, mean 0
  double beam_elevation_sigma_rad = 0.0014;  // 0.08 deg, the same for elevations
  BeamErrorShape beam_error_shape = BeamErrorShape::kIndependent;  // of ranges and elevations
  double beam_gain_sigma = 0.15;  // relative brightness of a laser: real scans are striped
  double loss_share = 0.01;       // of pulses, for no reason
  double reach_m = 60.0;          // a surface of reflectivity 0.1, hit head-on, is seen to here
  double intensity_step = 0.01;   // as KITTI stores it
  // Throws InputError naming the field.
  void Check() const;
};

// One sweep to take.
struct LidarSweep {
  // Pose of the sensor at an offset from the stamp, s, within half a revolution.
  std::function<Rigid3d(double)> T_world_lidar;
  uint64_t frame = 0;        // of the noise
  bool is_clockwise = true;  // seen from above; starts and ends behind, faces +x at the stamp
  bool is_compensated =
      true;  // points as seen from the pose at the stamp, else from where they were measured
};

// Immutable, thread-safe.
class LidarSensor {
 public:
  // `model` gives beams, revolution and vertical correction: the beams really point that much
  // higher than the elevations the points are stored with.
  LidarSensor(const LidarModel& model, const LidarSensorOptions& options);

  // A scan as in KITTI's files: ring after ring from the top, each starting straight ahead with
  // the azimuth rising to the left. `ring` and `time_offset_s` (0 if compensated) are filled in.
  // `view` must span the sweep: [stamp - sweep_s / 2, stamp + sweep_s / 2].
  LidarScan Scan(const SceneView& view, const LidarSweep& sweep, const Executor& executor) const;

 private:
  struct Firing;                        // of all beams at one azimuth
  struct Beam;                          // one laser
  struct Pulses;                        // a packet of a beam's pulses on their way
  struct Ring;                          // what comes back from one beam
  double Azimuth(size_t column) const;  // rad, 0..2 pi
  std::vector<Firing> Firings(const LidarSweep& sweep) const;
  Ring CastRing(const SceneView& view, const std::vector<Firing>& firings, int row,
                const LidarSweep& sweep) const;
  Beam BeamOf(int row) const;
  // Range or elevation errors by row, of the shape asked for.
  std::vector<double> BeamErrors(double sigma, Rng* independent, Rng* phase) const;
  // Adds a pulse.
  void Emit(const Beam& beam, const Firing& firing, Rng* rng, Pulses* pulses) const;
  // Adds the points of the pulses that come back.
  void Receive(const Beam& beam, const Pulses& pulses, const HitPacket& hits, bool is_compensated,
               Rng* rng, Ring* ring) const;
  // Whether a pulse comes back, and how bright: below 0 it does not.
  float Return(const SceneHit& hit, const Eigen::Vector3f& direction, float gain,
               uint64_t draw) const;

  LidarModel model_;
  LidarSensorOptions options_;
  std::vector<double> range_bias_m_, elevation_bias_rad_, gain_;  // by row
  std::vector<bool> hidden_;  // by row and column: the own car is in the way
};

// True where the own car hides the view: azimuth in degrees, 0..360 to the left from straight
// ahead, row of 64.
bool IsHiddenByCar(double azimuth_deg, int row);

}  // namespace tvl::sim
