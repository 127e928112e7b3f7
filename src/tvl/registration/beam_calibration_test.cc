#include "tvl/registration/beam_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/registration/beam_directions.h"

namespace tvl {
namespace {

constexpr int kRings = 8;

// One frame: every ring sees points of a flat road and of two walls, all of them exact but for the
// offsets of the rings that are not yet corrected.
struct Frame {
  std::vector<PlaneMatch> matches;
  std::vector<uint16_t> rings;
};

Frame Observe(const std::vector<double>& wrong_elevation_rad, const BeamOffsets& corrected,
              Rng& rng) {
  const Eigen::Vector3d normals[] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  const Eigen::Vector3d places[] = {{0, 0, -1.7}, {0, 8, 0}, {25, 0, 0}};
  Frame frame;
  for (int i = 0; i < 1200; ++i) {
    const int plane = i % 3;
    Eigen::Vector3d p(rng.Uniform(-25, 25), rng.Uniform(-8, 8), rng.Uniform(-1.7, 4));
    p -= normals[plane] * normals[plane].dot(p - places[plane]);
    const auto ring = static_cast<uint16_t>(rng.Integer(kRings));
    const double known = corrected.elevation_rad.empty() ? 0.0 : corrected.elevation_rad[ring];
    PlaneMatch match;
    match.factor = {p + (wrong_elevation_rad[ring] + known) * DirectionsAt(p).elevation,
                    normals[plane], places[plane]};
    match.information = 1.0 / (0.03 * 0.03);
    frame.matches.push_back(match);
    frame.rings.push_back(ring);
  }
  return frame;
}

TEST(BeamCalibration, FindsTheOffsetsOfSingleBeams) {
  Rng rng(8);
  const std::vector<double> wrong = {1e-3, -1e-3, 2e-3, 0.0, -2e-3, 5e-4, -5e-4, 0.0};
  BeamCalibration calibration(kRings, BeamCalibrationOptions());
  for (int k = 0; k < 200; ++k) {
    const Frame frame = Observe(wrong, calibration.offsets(), rng);
    calibration.Add(frame.matches, frame.rings, Rigid3d(), 3.0);
  }
  ASSERT_EQ(calibration.offsets().elevation_rad.size(), static_cast<size_t>(kRings));
  double sum = 0.0;
  for (size_t ring = 0; ring < kRings; ++ring) {
    EXPECT_NEAR(calibration.offsets().elevation_rad[ring], -wrong[ring], 3e-4) << ring;
    EXPECT_NEAR(calibration.offsets().range_m[ring], 0.0, 0.01) << ring;
    sum += calibration.offsets().elevation_rad[ring];
  }
  EXPECT_NEAR(sum, 0.0, 1e-6) << "what all beams share is not theirs to correct";
}

TEST(BeamCalibration, SaysNothingWhenOffOrWithoutBeams) {
  Rng rng(9);
  const Frame frame = Observe(std::vector<double>(kRings, 1e-3), {}, rng);
  BeamCalibrationOptions off;
  off.enabled = false;
  for (BeamCalibration calibration :
       {BeamCalibration(kRings, off), BeamCalibration(0, BeamCalibrationOptions())}) {
    for (int k = 0; k < 10; ++k) calibration.Add(frame.matches, frame.rings, Rigid3d(), 3.0);
    EXPECT_TRUE(calibration.offsets().elevation_rad.empty());
  }
}

TEST(ApplyBeamOffsets, RaisesAndLengthensItsOwnRingOnly) {
  std::vector<Eigen::Vector3f> points = {{10.0f, 0.0f, -2.0f}, {10.0f, 0.0f, -2.0f}};
  ApplyBeamOffsets({{0.001f, 0.0f}, {0.05f, 0.0f}}, {0, 1}, &points);
  const auto elevation = [](const Eigen::Vector3f& p) { return std::atan2(p.z(), p.x()); };
  EXPECT_NEAR(elevation(points[0]) - elevation(points[1]), 0.001, 1e-5);
  EXPECT_NEAR(points[0].norm() - points[1].norm(), 0.05, 1e-4);
  EXPECT_EQ(points[1], Eigen::Vector3f(10.0f, 0.0f, -2.0f));
}

TEST(BeamCalibration, NamesTheBadField) {
  BeamCalibrationOptions options;
  options.prior_range_m = 0.0;
  EXPECT_THROW(BeamCalibration(kRings, options), InputError);
}

}  // namespace
}  // namespace tvl
