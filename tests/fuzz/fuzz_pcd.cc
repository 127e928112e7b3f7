#include "fuzz_scan.h"
#include "tvl/io/cloud/pcd.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t bytes) {
  tvl::FuzzScan([&](const std::string& source) { return tvl::ParsePcd(data, bytes, source).scan; });
  return 0;
}
