#include "tvl/map/loop.h"

namespace tvl {

const char* ToString(LoopProposer proposer) {
  switch (proposer) {
    case LoopProposer::kVisual:
      return "visual";
    case LoopProposer::kVicinity:
      return "vicinity";
    case LoopProposer::kLidar:
      return "lidar";
  }
  return "unknown";
}

}  // namespace tvl
