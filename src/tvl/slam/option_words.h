// The words enumerations are written with in YAML.
#pragma once

#include <array>
#include <optional>
#include <utility>

#include "tvl/pose_graph/loop_loss.h"
#include "tvl/registration/surfel_map.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl {

template <typename Enum, size_t N>
using OptionWords = std::array<std::pair<const char*, Enum>, N>;

inline OptionWords<SurfelKind, 2> WordsOf(SurfelKind) {
  return {{{"plane", SurfelKind::kPlane}, {"line", SurfelKind::kLine}}};
}

inline OptionWords<LoopLoss, 4> WordsOf(LoopLoss) {
  return {{{"none", LoopLoss::kNone},
           {"huber", LoopLoss::kHuber},
           {"dcs", LoopLoss::kDcs},
           {"gnc", LoopLoss::kGnc}}};
}

inline OptionWords<std::optional<Deskew>, 4> WordsOf(const std::optional<Deskew>&) {
  return {{{"auto", std::nullopt},
           {"none", Deskew::kNone},
           {"cw", Deskew::kClockwise},
           {"ccw", Deskew::kCounterClockwise}}};
}

}  // namespace tvl
