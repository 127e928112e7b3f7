// From the numbers that the project counts things with (int: poses, loops, keyframes, -1 for
// "none") to positions in standard containers, which count with size_t.
#pragma once

#include <cstddef>

#include "tvl/base/check.h"

namespace tvl {

// `i` as a position in a container. A negative one is a broken contract: throws Error, where a
// plain cast would read far outside. What lies above the end is for the container to notice.
constexpr size_t Index(int i) {
  return i < 0 ? throw Error("negative index") : static_cast<size_t>(i);
}

}  // namespace tvl
