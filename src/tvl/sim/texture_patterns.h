// Painted surfaces of the simulated town: periodic grey pictures, drawn once from a seed and looked
// up by TextureTile. Values are 0..1 around 0.5 and scale the albedo of the material they are
// laid on. All are square with a side of kPatternSize texels and repeat without a seam.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace tvl::sim {

inline constexpr int kPatternSize = 1024;
inline constexpr float kPatternPeriod_m = 5.04F;  // 4.9 mm a texel; 21 bricks of 0.24 m

// Value noise of all wavelengths from 2 texels to half the period. An octave's amplitude grows
// with its wavelength to the power `roughness` (0: every octave alike).
cv::Mat PaintNoise(uint64_t seed, double roughness);
// Grit, stones, cracks and tar seams.
cv::Mat PaintAsphalt(uint64_t seed);
// Bricks of 0.24 x 0.074 m in running bond, each of its own tone, light joints.
cv::Mat PaintBricks(uint64_t seed);
// Rough plaster with stains and streaks running down (v grows upwards).
cv::Mat PaintPlaster(uint64_t seed);
// Leaves laid over each other, the lower ones in the dark.
cv::Mat PaintLeaves(uint64_t seed);
// Blades of grass with bare and light spots.
cv::Mat PaintGrass(uint64_t seed);
// Slabs of 0.36 m with dark joints.
cv::Mat PaintSlabs(uint64_t seed);
// Rows of roof tiles, 0.25 m wide and 0.315 m high.
cv::Mat PaintRoofTiles(uint64_t seed);
// Concrete with panel joints, bolts, run-down stains, stencilled signs and graffiti: a tunnel
// lining rich in corners.
cv::Mat PaintTunnelLining(uint64_t seed);

}  // namespace tvl::sim
