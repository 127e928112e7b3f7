// Distance of binary descriptors.
#pragma once

#include "tvl/frame/image_features.h"

namespace tvl {

// Ones in a word. Without the processor's instruction, which not every x86 has: 12 operations.
inline int CountOnes(uint64_t x) {
  x -= (x >> 1) & 0x5555555555555555ULL;
  x = (x & 0x3333333333333333ULL) + ((x >> 2) & 0x3333333333333333ULL);
  x = (x + (x >> 4)) & 0x0f0f0f0f0f0f0f0fULL;
  return static_cast<int>((x * 0x0101010101010101ULL) >> 56);
}

// Bits that differ, 0..256.
inline int HammingDistance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  int bits = 0;
  for (size_t i = 0; i < a.size(); ++i) bits += CountOnes(a[i] ^ b[i]);
  return bits;
}

}  // namespace tvl
