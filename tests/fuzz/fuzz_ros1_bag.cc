// Any bytes as a ROS 1 bag: opening throws InputError or gives an index all of whose messages can
// be asked for.
#include "read_store.h"
#include "tvl/io/ros/ros1_bag.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t bytes) {
  const std::shared_ptr<const tvl::ByteSource> source = tvl::MemorySource("fuzz.bag", data, bytes);
  try {
    tvl::ReadStore(tvl::Ros1Bag(source));
  } catch (const tvl::InputError&) {
    return 0;
  }
  return 0;
}
