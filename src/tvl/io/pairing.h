// Which image belongs to which scan: cameras and lidars run at rates and offsets of their own.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "tvl/base/time.h"

namespace tvl {

// For each instant, in any order, the index of the nearest image within `within_s`; an image
// belongs to one scan at most, the one it is nearest to. `images` ascend.
std::vector<std::optional<size_t>> PairImages(const std::vector<Timestamp>& instants,
                                              const std::vector<Timestamp>& images,
                                              double within_s);

// Median time between neighbours, s; `otherwise_s` where there are fewer than two stamps or they
// stand still.
double MedianPeriod_s(const std::vector<Timestamp>& stamps, double otherwise_s);

}  // namespace tvl
