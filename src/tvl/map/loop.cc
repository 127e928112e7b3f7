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

const char* ToString(LoopStatus status) {
  switch (status) {
    case LoopStatus::kAccepted:
      return "accepted";
    case LoopStatus::kNoStart:
      return "no start";
    case LoopStatus::kFewPoints:
      return "few points";
    case LoopStatus::kWeak:
      return "weak";
    case LoopStatus::kHighRms:
      return "high rms";
    case LoopStatus::kLowOverlap:
      return "low overlap";
    case LoopStatus::kContradicted:
      return "contradicted";
    case LoopStatus::kAmbiguous:
      return "ambiguous";
  }
  return "unknown";
}

}  // namespace tvl
