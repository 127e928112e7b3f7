// Distances along a driven path.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tvl/geometry/rigid3.h"

namespace tvl {

// Metres driven from the first pose to each pose; as long as `poses`.
std::vector<double> PathLengths(const std::vector<Rigid3d>& poses);

// The first index > `first` that lies more than `distance_m` of path after it; none if the path
// ends before. `lengths_m` as from PathLengths.
std::optional<size_t> IndexAfter(const std::vector<double>& lengths_m, size_t first,
                                 double distance_m);

}  // namespace tvl
