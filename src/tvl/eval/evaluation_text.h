// An evaluation for programs (JSON) and for people (a table).
#pragma once

#include <string>

#include "tvl/eval/evaluation.h"

namespace tvl {

// Keys carry their units; numbers that do not exist (drive too short) are null.
std::string ToJson(const Evaluation& evaluation);

// A block of lines for each drive, means below where there are several.
std::string ToTable(const Evaluation& evaluation);

}  // namespace tvl
