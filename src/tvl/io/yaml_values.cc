#include "tvl/io/yaml_values.h"

#include <fstream>
#include <sstream>

namespace tvl {

std::string Where(const std::string& source, const YAML::Node& node, const std::string& key) {
  std::ostringstream out;
  out << source << ":" << node.Mark().line + 1 << ": " << key;
  return out.str();
}

YAML::Node ParseYaml(const std::string& yaml, const std::string& source) {
  try {
    return YAML::Load(yaml);
  } catch (const YAML::Exception& e) {
    throw InputError(source + ": " + e.what());
  }
}

std::string ReadWholeText(const std::string& path) {
  std::ifstream file(path);
  TVL_CHECK_INPUT(file.good()) << path << ": cannot be read";
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace tvl
