// Any bytes as an MCAP file: opening throws InputError or gives an index all of whose messages can
// be asked for.
#include "read_store.h"
#include "tvl/io/ros/mcap.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t bytes) {
  const std::shared_ptr<const tvl::ByteSource> source = tvl::MemorySource("fuzz.mcap", data, bytes);
  try {
    tvl::ReadStore(tvl::Mcap(source));
  } catch (const tvl::InputError&) {
    return 0;
  }
  return 0;
}
