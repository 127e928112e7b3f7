// How the constant errors of a lidar's beams are spread over its rings.
#pragma once

namespace tvl::sim {

// Mean 0: what all beams have in common is not theirs.
enum class BeamErrorShape {
  kIndependent,  // a normal number for each beam
  kSine,         // one period from the top ring to the bottom one, of the same rms
};

}  // namespace tvl::sim
