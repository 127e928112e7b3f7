#include "tvl/sim/lidar_sensor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"

namespace tvl::sim {
namespace {

using Eigen::Vector3f;

constexpr uint64_t kBiasStream = 701, kPhaseStream = 702, kNoiseStream = 1ULL << 40;

// What the car of KITTI hides, read off the real scans: ellipses over azimuth and row. The lower
// edge of the picture is row 63; blobs whose middle lies below it are the roof's edges.
struct HiddenBlob {
  double azimuth_deg, row;             // middle
  double half_width_deg, half_height;  // of the ellipse
};
constexpr HiddenBlob kHidden[] = {
    {0, 67, 30, 11.5},                                    // front of the roof
    {185, 68, 40, 16}, {166, 51, 7, 6}, {202, 50, 6, 4},  // rear, with the camera's mounts
    {292, 53, 11, 9},                                     // antenna
    {31, 63, 6, 2.5},  {135, 61, 6, 4}, {233, 61, 6, 4}, {326, 62, 6, 3},  // rack
};

// The row of an HDL-64E (2 deg to -8.33 deg, -8.83 deg to -24.33 deg, 32 rows each) that looks
// where a beam looks; rows go on above and below.
int RowOfHdl64(double elevation_deg) {
  const double upper = 3.0 * (2.0 - elevation_deg);
  const double lower = 32.0 + 2.0 * (-8.8333333 - elevation_deg);
  return static_cast<int>(std::lround(elevation_deg > -8.58 ? upper : lower));
}

// Random numbers of mean exactly 0: what all beams have in common is not theirs.
std::vector<double> Biases(int count, double sigma, Rng* rng) {
  std::vector<double> biases;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) sum += biases.emplace_back(sigma * rng->Normal());
  for (double& bias : biases) bias -= sum / count;
  return biases;
}

// Zero mean, unit variance, bounded: the sum of four 16-bit numbers. Half the price of a true
// normal number, and a pulse has three of them.
float QuickNormal(Rng* rng) {
  const uint64_t bits = rng->Next();
  const auto sum = static_cast<float>((bits & 0xffff) + ((bits >> 16) & 0xffff) +
                                      ((bits >> 32) & 0xffff) + (bits >> 48));
  return (sum / 65536.0F - 2.0F) * 1.7320508F;
}

// In [0, 1), from some bits of a hash.
float Unit(uint64_t bits) { return static_cast<float>(bits & 0xffffff) / 16777216.0F; }

// Relative change of the reflectivity: from object to object, and less so over a surface, by cells
// of 0.15 m of the object's own frame.
float SurfaceTone(const SceneHit& hit, float variation) {
  const auto cell = [](float v) {
    return static_cast<uint64_t>(static_cast<int64_t>(std::floor(v / 0.15F)) & 0xfffff);
  };
  const uint64_t place =
      cell(hit.p_object.x()) | (cell(hit.p_object.y()) << 20) | (cell(hit.p_object.z()) << 40);
  const float here = Unit(Rng::Mix(place)) - 0.5F;
  const float whole = Unit(Rng::Mix(hit.object + 0x9e37ULL)) - 0.5F;
  return std::min(variation, 0.3F) * here + 1.4F * variation * whole;
}

}  // namespace

void LidarSensorOptions::Check() const {
  TVL_CHECK_INPUT(columns >= RayPacket::kWidth) << "columns: too few, is " << columns;
  TVL_CHECK_INPUT(max_range_m > min_range_m && min_range_m > 0.0)
      << "min_range_m, max_range_m: want 0 < min < max";
  TVL_CHECK_INPUT(range_sigma_m >= 0.0) << "range_sigma_m: negative";
  TVL_CHECK_INPUT(angle_sigma_rad >= 0.0) << "angle_sigma_rad: negative";
  TVL_CHECK_INPUT(loss_share >= 0.0 && loss_share < 1.0) << "loss_share: want 0 <= x < 1";
  TVL_CHECK_INPUT(reach_m > 0.0) << "reach_m: must be positive";
  TVL_CHECK_INPUT(intensity_step > 0.0) << "intensity_step: must be positive";
}

struct LidarSensor::Firing {
  double azimuth_rad;  // 0 straight ahead, rising to the left
  float cos_azimuth, sin_azimuth;
  double offset_s;  // from the stamp
  Eigen::Matrix3f R_world_lidar;
  Vector3f origin_world;
  Eigen::Matrix3f R_out;  // from where it was measured to the frame of the scan
  Vector3f t_out;
};

struct LidarSensor::Ring {
  std::vector<Vector3f> points;
  std::vector<float> intensity, time_offset_s;
};

// What all pulses of one beam share.
struct LidarSensor::Beam {
  float sin_stored, cos_stored;  // of the elevation its points are stored with
  float sin_real, cos_real;      // of the elevation it really has
  float angle_sigma_rad, range_sigma_m, range_bias_m, gain;
};

// Pulses on their way.
struct LidarSensor::Pulses {
  RayPacket rays;
  std::array<Vector3f, RayPacket::kWidth> stored_direction;  // lidar frame
  std::array<Vector3f, RayPacket::kWidth> real_direction;    // world frame
  std::array<const Firing*, RayPacket::kWidth> firing;
};

LidarSensor::LidarSensor(const LidarModel& model, const LidarSensorOptions& options)
    : model_(model), options_(options) {
  options_.Check();
  TVL_CHECK_INPUT(model_.rows() > 0) << "lidar: a simulated lidar needs beam elevations";
  Rng rng(options_.seed, kBiasStream), phase(options_.seed, kPhaseStream);
  const double scale = options_.has_errors ? 1.0 : 0.0;
  range_bias_m_ = BeamErrors(scale * options_.beam_range_sigma_m, &rng, &phase);
  elevation_bias_rad_ = BeamErrors(scale * options_.beam_elevation_sigma_rad, &rng, &phase);
  gain_ = Biases(model_.rows(), scale * options_.beam_gain_sigma, &rng);
  for (const double elevation_rad : model_.beam_elevation_rad) {
    const int row = RowOfHdl64(RadToDeg(elevation_rad));
    for (size_t i = 0; i < static_cast<size_t>(options_.columns); ++i) {
      hidden_.push_back(options_.has_errors && IsHiddenByCar(RadToDeg(Azimuth(i)), row));
    }
  }
}

std::vector<double> LidarSensor::BeamErrors(double sigma, Rng* independent, Rng* phase) const {
  // Drawn in any case: what comes after is the same for every shape.
  std::vector<double> errors = Biases(model_.rows(), sigma, independent);
  if (options_.beam_error_shape == BeamErrorShape::kIndependent) return errors;
  const double first_rad = 2.0 * kPi * phase->Uniform();
  const double step_rad = 2.0 * kPi / static_cast<double>(errors.size());
  for (size_t i = 0; i < errors.size(); ++i) {
    errors[i] = std::sqrt(2.0) * sigma * std::sin(first_rad + step_rad * static_cast<double>(i));
  }
  return errors;
}

double LidarSensor::Azimuth(size_t column) const {
  return 2.0 * kPi * (static_cast<double>(column) + 0.5) / options_.columns;
}

std::vector<LidarSensor::Firing> LidarSensor::Firings(const LidarSweep& sweep) const {
  const auto n = static_cast<size_t>(options_.columns);
  std::vector<Firing> firings(n);
  const Rigid3d T_lidar_world = sweep.T_world_lidar(0.0).Inverse();
  for (size_t i = 0; i < n; ++i) {
    Firing& f = firings[i];
    f.azimuth_rad = Azimuth(i);
    f.cos_azimuth = static_cast<float>(std::cos(f.azimuth_rad));
    f.sin_azimuth = static_cast<float>(std::sin(f.azimuth_rad));
    const double turn = f.azimuth_rad > kPi ? f.azimuth_rad - 2.0 * kPi : f.azimuth_rad;
    f.offset_s = (sweep.is_clockwise ? -turn : turn) / (2.0 * kPi) * model_.sweep_s;
    const Rigid3d T_world_lidar = sweep.T_world_lidar(f.offset_s);
    f.R_world_lidar = T_world_lidar.R().cast<float>();
    f.origin_world = T_world_lidar.t().cast<float>();
    const Rigid3d out = sweep.is_compensated ? T_lidar_world * T_world_lidar : Rigid3d();
    f.R_out = out.R().cast<float>();
    f.t_out = out.t().cast<float>();
  }
  return firings;
}

float LidarSensor::Return(const SceneHit& hit, const Vector3f& direction, float gain,
                          uint64_t draw) const {
  const LidarSurface surface = LidarSurfaceOf(hit.material);
  const float tone = 1.0F + SurfaceTone(hit, surface.variation);
  const float reflectivity = std::clamp(surface.reflectivity * tone, 0.01F, 1.0F);
  const float cosine = std::abs(hit.normal.dot(direction));
  if (options_.has_errors) {
    if (Unit(draw) < static_cast<float>(options_.loss_share)) return -1.0F;
    if (Unit(draw >> 12) < surface.mirror * (1.25F - 0.5F * cosine)) return -1.0F;
    const float grazing = 1.0F - cosine;
    const float mirrored = surface.film * grazing * grazing * grazing * grazing * grazing;
    if (surface.film > 0.0F && Unit(draw >> 36) < mirrored) return -1.0F;
    // What comes back falls with the square of the range and, less than Lambert's law says, with
    // the incidence; near the threshold some pulses make it.
    const float r = hit.range_m / static_cast<float>(options_.reach_m);
    const float needed = 0.1F * r * r * (0.6F + 0.8F * Unit(draw >> 24));
    if (reflectivity * std::sqrt(cosine) < needed) return -1.0F;
  }
  // The sensor evens out the range and most of the incidence, not the differences of its lasers.
  // The weakest read 0: some 6-25 % in real scans, most of them glass and dark paint.
  const float intensity = 1.25F * gain * reflectivity * (0.55F + 0.45F * std::sqrt(cosine)) - 0.07F;
  const auto step = static_cast<float>(options_.intensity_step);
  return std::clamp(std::floor(intensity / step) * step, 0.0F, 0.99F);
}

LidarSensor::Beam LidarSensor::BeamOf(int row) const {
  const auto i = static_cast<size_t>(row);
  const double stored = model_.beam_elevation_rad[i];
  const double real = stored + model_.vertical_correction_rad + elevation_bias_rad_[i];
  const double noise = options_.has_errors ? 1.0 : 0.0;
  const auto f = [](double v) { return static_cast<float>(v); };
  return {f(std::sin(stored)),
          f(std::cos(stored)),
          f(std::sin(real)),
          f(std::cos(real)),
          f(noise * options_.angle_sigma_rad),
          f(noise * options_.range_sigma_m),
          f(range_bias_m_[i]),
          f(1.0 + gain_[i])};
}

void LidarSensor::Emit(const Beam& beam, const Firing& f, Rng* rng, Pulses* pulses) const {
  const float ca = f.cos_azimuth, sa = f.sin_azimuth;
  // A pulse leaves a little off: to the left by da, upwards by de.
  const float da = beam.angle_sigma_rad * QuickNormal(rng);
  const float de = beam.angle_sigma_rad * QuickNormal(rng);
  const float level = beam.cos_real - de * beam.sin_real;
  const Vector3f direction(level * ca - da * sa, level * sa + da * ca,
                           beam.sin_real + de * beam.cos_real);
  const int lane = pulses->rays.count;
  const auto l = static_cast<size_t>(lane);
  pulses->stored_direction[l] = {beam.cos_stored * ca, beam.cos_stored * sa, beam.sin_stored};
  pulses->real_direction[l] = (f.R_world_lidar * direction).normalized();
  pulses->firing[l] = &f;
  pulses->rays.Set(lane, f.origin_world, pulses->real_direction[l],
                   static_cast<float>(options_.max_range_m),
                   static_cast<float>(f.offset_s / model_.sweep_s + 0.5));
}

void LidarSensor::Receive(const Beam& beam, const Pulses& pulses, const HitPacket& hits,
                          bool is_compensated, Rng* rng, Ring* ring) const {
  for (size_t l = 0; l < static_cast<size_t>(pulses.rays.count); ++l) {
    const uint64_t draw = rng->Next();
    const float range = hits[l].range_m + beam.range_bias_m + beam.range_sigma_m * QuickNormal(rng);
    if (!hits[l].hit || range < static_cast<float>(options_.min_range_m) ||
        range > static_cast<float>(options_.max_range_m)) {
      continue;
    }
    const float intensity = Return(hits[l], pulses.real_direction[l], beam.gain, draw);
    if (intensity < 0.0F) continue;
    const Firing& f = *pulses.firing[l];
    ring->points.emplace_back(f.R_out * (range * pulses.stored_direction[l]) + f.t_out);
    ring->intensity.push_back(intensity);
    ring->time_offset_s.push_back(is_compensated ? 0.0F : static_cast<float>(f.offset_s));
  }
}

LidarSensor::Ring LidarSensor::CastRing(const SceneView& view, const std::vector<Firing>& firings,
                                        int row, const LidarSweep& sweep) const {
  Rng rng(Rng::Mix(options_.seed) ^ sweep.frame, kNoiseStream + static_cast<uint64_t>(row));
  const Beam beam = BeamOf(row);
  Ring ring;
  ring.points.reserve(firings.size());
  ring.intensity.reserve(firings.size());
  ring.time_offset_s.reserve(firings.size());
  for (size_t next = 0; next < firings.size();) {
    Pulses pulses;
    for (; next < firings.size() && pulses.rays.count < RayPacket::kWidth; ++next) {
      if (hidden_[static_cast<size_t>(row) * firings.size() + next]) continue;
      Emit(beam, firings[next], &rng, &pulses);
    }
    if (pulses.rays.count == 0) break;
    Receive(beam, pulses, view.Intersect(pulses.rays), sweep.is_compensated, &rng, &ring);
  }
  return ring;
}

LidarScan LidarSensor::Scan(const SceneView& view, const LidarSweep& sweep,
                            const Executor& executor) const {
  const std::vector<Firing> firings = Firings(sweep);
  std::vector<Ring> rings(static_cast<size_t>(model_.rows()));
  executor.For(rings.size(), 1, [&](size_t row, size_t) {
    rings[row] = CastRing(view, firings, static_cast<int>(row), sweep);
  });
  LidarScan scan;
  for (size_t row = 0; row < rings.size(); ++row) {
    const Ring& r = rings[row];
    scan.points.insert(scan.points.end(), r.points.begin(), r.points.end());
    scan.intensity.insert(scan.intensity.end(), r.intensity.begin(), r.intensity.end());
    scan.time_offset_s.insert(scan.time_offset_s.end(), r.time_offset_s.begin(),
                              r.time_offset_s.end());
    scan.ring.insert(scan.ring.end(), r.points.size(), static_cast<uint16_t>(row));
  }
  return scan;
}

bool IsHiddenByCar(double azimuth_deg, int row) {
  // The edges are frayed: lasers of neighbouring rows do not sit above each other.
  const double azimuth = azimuth_deg + (row % 2 == 0 ? 1.2 : -1.2);
  return std::any_of(std::begin(kHidden), std::end(kHidden), [&](const HiddenBlob& blob) {
    const double away = std::remainder(azimuth - blob.azimuth_deg, 360.0) / blob.half_width_deg;
    const double up = (row - blob.row) / blob.half_height;
    return away * away + up * up < 1.0;
  });
}

}  // namespace tvl::sim
