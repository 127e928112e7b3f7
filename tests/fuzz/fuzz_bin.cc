#include "fuzz_scan.h"
#include "tvl/io/cloud/bin_points.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t bytes) {
  tvl::FuzzScan([&](const std::string& source) {
    const tvl::BinLayout layout = tvl::RecogniseBinLayout({tvl::SampleOfBin(data, bytes)}, source);
    return tvl::ParseBinPoints(data, bytes, layout, source).scan;
  });
  return 0;
}
