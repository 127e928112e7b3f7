// The keys of an options file, flat: which there are, where they stand, and whether they exist.
#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <string>
#include <vector>

namespace tvl {

// A key of the file with its value.
struct OptionEntry {
  std::string key;  // full: "mapping.interval"
  YAML::Node value;
  int line = 0;  // from 1
};
using OptionEntries = std::map<std::string, OptionEntry>;  // by key

// What can be set: the values, and the sections they lie in.
struct KnownKeys {
  std::vector<std::string> values, sections;
};

// "source:line: ", the head of a message.
std::string AtLine(const std::string& source, int line);

// The entries of a YAML text by full key, however it nests or dots them. Throws InputError naming
// source and line for text that is no YAML, for keys that are not known (with the nearest that is)
// and for those given twice.
OptionEntries ReadEntries(const std::string& yaml, const std::string& source,
                          const KnownKeys& known);

}  // namespace tvl
