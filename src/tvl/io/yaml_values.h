// Values out of YAML files, with errors that name file, line and key. For the readers of this
// folder.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>

#include "tvl/base/check.h"
#include "tvl/sensor/lidar_model.h"

namespace tvl {

// "source:line: key", the head of every message.
std::string Where(const std::string& source, const YAML::Node& node, const std::string& key);

// Throws InputError beginning with `where` for another kind of value.
template <typename T>
T As(const YAML::Node& node, const std::string& where) {
  try {
    return node.as<T>();
  } catch (const YAML::Exception&) {
    throw InputError(where + ": wrong kind of value");
  }
}

// Throw InputError beginning with `source`, or the path.
YAML::Node ParseYaml(const std::string& yaml, const std::string& source);
std::string ReadWholeText(const std::string& path);

// The keys of a profile's `lidar` section, see profile.h.
LidarModel LidarOfSection(const YAML::Node& section, const std::string& source);

}  // namespace tvl
