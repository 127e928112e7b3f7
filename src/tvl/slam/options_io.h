// Options as YAML files: overrides on top of the defaults.
//
//   mapping:
//     interval: 5            # sections nest as the structs do ...
//   mapping.keyframes.min_rotation_deg: 11.5  # ... or are written into the key
//
// Every option, its default, unit and reason: docs/options.md. Angles are degrees (`_deg`) in files
// and radians (`_rad`) in the code. Unknown keys are errors, so a misspelt option never passes
// for its default.
#pragma once

#include <string>
#include <vector>

#include "tvl/slam/slam_runner.h"

namespace tvl {

// `base` with the options of a YAML text; `source` names it in errors. Throws InputError naming
// source, line and key for text that is no YAML, unknown or repeated keys (with the nearest known
// one), values of the wrong kind and values that Check() refuses. Threads are left as in `base`.
RunOptions ApplyYaml(const std::string& yaml, const std::string& source, const RunOptions& base);

// The same for a file. Throws InputError also when it cannot be read.
RunOptions LoadOptions(const std::string& path, const RunOptions& base = {});

// All options as YAML: complete, and loaded again they are the same.
std::string DumpOptions(const RunOptions& options);

// Full keys ("mapping.interval") of all options, in the order of the dump.
std::vector<std::string> OptionKeys();

}  // namespace tvl
