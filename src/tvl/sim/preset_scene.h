// What stands and moves in the world of a preset.
#pragma once

#include "tvl/sim/drive.h"
#include "tvl/sim/scene.h"
#include "tvl/sim/sim_options.h"

namespace tvl::sim {

SceneDescription DescribeScene(const SimOptions& options, const Drive& drive);

}  // namespace tvl::sim
