#include "fuzz_scan.h"
#include "tvl/io/cloud/ply.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t bytes) {
  tvl::FuzzScan([&](const std::string& source) { return tvl::ParsePly(data, bytes, source).scan; });
  return 0;
}
