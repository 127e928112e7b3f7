// The A:B of --frames.
#pragma once

#include <cstddef>
#include <string>

namespace tvl {

struct FrameRange {
  size_t begin = 0, end = 0;  // [begin, end)
};

// "" is all of `size` frames, "A:" from A on, ":B" up to B - 1. Throws InputError for anything else
// and for ranges without a frame.
FrameRange ParseFrameRange(const std::string& text, size_t size);

// A of the range alone, before the size is known.
size_t FirstFrame(const std::string& text);

}  // namespace tvl
