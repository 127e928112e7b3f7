// Identifiers that cannot be mixed up.
#pragma once

#include <cstdint>

namespace tvl {

// Position of a frame in its input, from 0; frames that could not be used keep their number.
using FrameId = int64_t;

// A visual track: never reused within a session.
using TrackId = int64_t;

// A keyframe. The session makes maps of several runs mergeable.
struct KeyframeId {
  int32_t session = 0;
  int32_t index = 0;
  friend bool operator==(KeyframeId a, KeyframeId b) {
    return a.session == b.session && a.index == b.index;
  }
  friend bool operator<(KeyframeId a, KeyframeId b) {
    return a.session != b.session ? a.session < b.session : a.index < b.index;
  }
};

}  // namespace tvl
