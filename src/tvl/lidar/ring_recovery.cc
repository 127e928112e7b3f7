#include "tvl/lidar/ring_recovery.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/base/units.h"

namespace tvl {
namespace {

// More than any lidar has; a range image of so many rows would fill the memory.
constexpr int kMostRings = 1024;
// Complete scans from one that is remembered to the next.
constexpr int kRememberedEvery = 10;

constexpr float kTwoPi = static_cast<float>(2.0 * kPi);

// +1 where azimuth rises with the stored order, -1 where it falls: the majority of the steps.
float StorageSense(const ScanGeometry& geometry) {
  int64_t balance = 0;
  for (size_t i = 8; i < geometry.azimuth_rad.size(); i += 8) {  // a sample is enough
    const float step = geometry.azimuth_rad[i] - geometry.azimuth_rad[i - 1];
    if (std::abs(step) < 0.1f) balance += step > 0.0f ? 1 : (step < 0.0f ? -1 : 0);
  }
  return balance < 0 ? -1.0f : 1.0f;
}

// A handful of points after the last pass of the start trembled across it: no ring of their own.
RingAssignment DropStump(RingAssignment out) {
  constexpr size_t kStump = 5;
  const uint16_t last = static_cast<uint16_t>(std::max(out.rings_found - 1, 0));
  size_t begin = out.row.size();
  while (begin > 0 && out.row[begin - 1] == last) --begin;
  if (last == 0 || out.row.size() - begin > kStump) return out;
  std::fill(out.row.begin() + static_cast<std::ptrdiff_t>(begin), out.row.end(),
            static_cast<uint16_t>(last - 1));
  --out.rings_found;
  return out;
}

// Turn number of each point, from 0, in `row`, and how many there are in `rings_found`.
RingAssignment CountTurns(const ScanGeometry& geometry, double start_azimuth_rad,
                          const RingRecoveryOptions& options, RingAssignment out) {
  const float sense = StorageSense(geometry);
  const float start = static_cast<float>(start_azimuth_rad);
  const float tolerance = static_cast<float>(options.max_backstep_rad);
  const float min_range_m = static_cast<float>(options.min_range_m);
  int turn = 0;
  float previous = 0.0f;
  out.row.resize(geometry.range_m.size());
  out.rings_found = 0;
  for (size_t i = 0; i < out.row.size(); ++i) {
    if (geometry.range_m[i] >= min_range_m) {
      float phase = sense * (geometry.azimuth_rad[i] - start);  // [0, 2 pi) from the ring's start
      if (phase < 0.0f) phase += kTwoPi;
      const float step = phase - previous;
      if (step < -tolerance) {
        ++turn;
      } else if (step > kTwoPi - tolerance) {
        --turn;  // trembling about the start: still the ring before
      }
      previous = phase;
    }
    out.row[i] = static_cast<uint16_t>(std::clamp(turn, 0, 65535));
    out.rings_found = std::max(out.rings_found, std::max(turn, 0) + 1);
  }
  return DropStump(std::move(out));
}

// Median of a ring's distances and heights, from points beyond 8 m where there are enough.
std::vector<RingProfile> ProfileRings(const LidarScan& scan, const ScanGeometry& geometry,
                                      const std::vector<uint16_t>& ring, int rings) {
  // The median point by elevation stands for the ring.
  struct Sample {
    float tangent, distance_m;
  };
  std::vector<std::vector<Sample>> far(static_cast<size_t>(rings)), all(far);
  for (size_t i = 0; i < ring.size(); i += 3) {
    if (geometry.range_m[i] < 0.5f) continue;
    const float distance_m = scan.points[i].head<2>().norm();
    const Sample sample{scan.points[i].z() / std::max(distance_m, 0.1f), distance_m};
    all[ring[i]].push_back(sample);
    if (distance_m > 8.0f) far[ring[i]].push_back(sample);
  }
  std::vector<RingProfile> profiles(static_cast<size_t>(rings));
  for (size_t r = 0; r < profiles.size(); ++r) {
    // Where most of a ring is near, its far points are those that strayed to another elevation.
    std::vector<Sample>& v =
        far[r].size() >= std::max<size_t>(30, all[r].size() / 2) ? far[r] : all[r];
    if (v.empty()) {
      if (r > 0) profiles[r] = profiles[r - 1];
      continue;
    }
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end(),
                     [](const Sample& a, const Sample& b) { return a.tangent < b.tangent; });
    profiles[r] = {static_cast<double>(middle->distance_m),
                   static_cast<double>(middle->tangent * middle->distance_m)};
  }
  return profiles;
}

RingAssignment UseGivenRings(const LidarScan& scan, const LidarModel& model, RingAssignment out) {
  out.source = RingSource::kGiven;
  out.row.assign(scan.ring.begin(), scan.ring.end());
  const uint16_t highest =
      scan.ring.empty() ? uint16_t{0} : *std::max_element(scan.ring.begin(), scan.ring.end());
  TVL_CHECK_INPUT(model.rows() == 0 || highest < model.rows())
      << "scan: ring " << highest << ", but lidar '" << model.name << "' has " << model.rows()
      << " beams";
  TVL_CHECK_INPUT(highest < kMostRings) << "scan: ring " << highest << ": no lidar has as many";
  out.rows = model.rows() > 0 ? model.rows() : highest + 1;
  std::vector<uint8_t> seen(static_cast<size_t>(highest) + 1, 0);
  for (const uint16_t r : scan.ring) seen[r] = 1;
  out.rings_found = static_cast<int>(std::count(seen.begin(), seen.end(), uint8_t{1}));
  return out;
}

// Row whose middle is nearest in elevation.
RingAssignment SliceByElevation(const LidarScan& scan, const LidarModel& model,
                                RingAssignment out) {
  out.source = RingSource::kSlices;
  out.rows = model.rows();
  TVL_CHECK_INPUT(out.rows > 1) << "lidar '" << model.name << "': slices need two elevations";
  const float top_rad = static_cast<float>(model.beam_elevation_rad.front());
  const float rows_per_rad = static_cast<float>(out.rows - 1) /
                             (top_rad - static_cast<float>(model.beam_elevation_rad.back()));
  const float last = static_cast<float>(out.rows - 1);
  out.row.resize(scan.size());
  for (size_t i = 0; i < scan.size(); ++i) {
    const Eigen::Vector3f& p = scan.points[i];
    const float elevation_rad = FastAtan2(p.z(), std::sqrt(p.x() * p.x() + p.y() * p.y()));
    const float row = (top_rad - elevation_rad) * rows_per_rad + 0.5F;
    out.row[i] = static_cast<uint16_t>(row > 0.0F ? std::min(row, last) : 0.0F);
  }
  out.rings_found = out.rows;
  return out;
}

void CheckStoredByRing(size_t points, int turns, const LidarModel& model) {
  const size_t most = static_cast<size_t>(turns) * 2 * static_cast<size_t>(model.columns);
  TVL_CHECK_INPUT(points <= most)
      << "scan: " << points << " points make only " << turns
      << " turns: not stored ring after ring, and no ring numbers are given";
  TVL_CHECK_INPUT(model.rows() == 0 || turns <= 2 * model.rows())
      << "scan: " << turns << " turns for the " << model.rows() << " beams of lidar '" << model.name
      << "': not stored ring after ring, and no ring numbers are given";
  TVL_CHECK_INPUT(turns <= kMostRings)
      << "scan: " << turns << " turns: not stored ring after ring, and no ring numbers are given";
}

}  // namespace

void RingRecoveryOptions::Check() const {
  TVL_CHECK_INPUT(max_backstep_rad > 0.0 && max_backstep_rad < 1.0)
      << "rings.max_backstep_rad: want 0..1, is " << max_backstep_rad;
  TVL_CHECK_INPUT(min_range_m >= 0.0) << "rings.min_range_m: must not be negative";
}

RingAssignment RecoverRings(const LidarScan& scan, const ScanGeometry& geometry,
                            const LidarModel& model, const RingRecoveryOptions& options,
                            RingMemory* memory, RingAssignment reuse) {
  TVL_CHECK(geometry.range_m.size() == scan.size());
  TVL_CHECK(scan.ring.empty() || scan.ring.size() == scan.size());
  if (!model.rows_are_beams) return SliceByElevation(scan, model, std::move(reuse));
  if (!scan.ring.empty()) return UseGivenRings(scan, model, std::move(reuse));
  RingAssignment out =
      CountTurns(geometry, model.ring_start_azimuth_rad, options, std::move(reuse));
  CheckStoredByRing(scan.size(), out.rings_found, model);
  out.rows = model.rows() > 0 ? model.rows() : out.rings_found;
  out.source = RingSource::kOneToOne;
  out.elevation_offset_rad = out.origin_height_m = out.elevation_rms_rad = 0.0;
  if (scan.size() == 0 || model.rows() == 0) return out;
  if (out.rings_found == out.rows) {
    if (memory != nullptr && memory->scans++ % kRememberedEvery == 0) {
      memory->complete = ProfileRings(scan, geometry, out.row, out.rings_found);
    }
    return out;
  }
  const std::vector<RingProfile> rings = ProfileRings(scan, geometry, out.row, out.rings_found);
  const RingAlignment alignment = memory != nullptr && !memory->complete.empty()
                                      ? AlignRingsToScan(rings, memory->complete)
                                      : AlignRingsToBeams(rings, model.beam_elevation_rad);
  out.source = RingSource::kAligned;
  out.elevation_offset_rad = alignment.offset_rad;
  out.origin_height_m = alignment.origin_height_m;
  out.elevation_rms_rad = alignment.rms_rad;
  for (uint16_t& r : out.row) r = static_cast<uint16_t>(alignment.row[r]);
  return out;
}

}  // namespace tvl
