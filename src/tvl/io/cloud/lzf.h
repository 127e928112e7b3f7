// LZF, the compression of PCD's binary_compressed data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tvl {

// Unpacks LZF data that must come to exactly `unpacked_bytes`. Memory is taken only for a size that
// the packed bytes can come to: at most 88 times their own. Throws InputError beginning with
// `source` and naming the packed byte for anything else.
std::vector<uint8_t> UnpackLzf(const uint8_t* packed, size_t packed_bytes, size_t unpacked_bytes,
                               const std::string& source);

}  // namespace tvl
