#include "tvl/io/profile.h"

#include <filesystem>

#include "tvl/base/check.h"
#include "tvl/base/units.h"
#include "tvl/io/embedded_profiles.h"
#include "tvl/io/yaml_values.h"

namespace tvl {
namespace {

std::vector<double> BeamBlocks(const YAML::Node& node, const std::string& where) {
  std::vector<double> beams_rad;
  for (const auto& block : As<std::vector<std::vector<double>>>(node, where)) {
    TVL_CHECK_INPUT(block.size() == 3 && block[2] >= 1.0 && block[2] <= 4096.0)
        << where << ": each block is [first, last, count]";
    const int count = static_cast<int>(block[2]);
    for (int i = 0; i < count; ++i) {
      const double share = count > 1 ? static_cast<double>(i) / (count - 1) : 0.0;
      beams_rad.push_back(DegToRad(block[0] + share * (block[1] - block[0])));
    }
  }
  return beams_rad;
}

std::vector<double> BeamList(const YAML::Node& node, const std::string& where) {
  std::vector<double> beams_rad;
  for (const double deg : As<std::vector<double>>(node, where)) beams_rad.push_back(DegToRad(deg));
  return beams_rad;
}

// The model with one key of the `lidar` section applied.
LidarModel WithKey(LidarModel model, const std::string& key, const YAML::Node& value,
                   const std::string& where) {
  if (key == "name") {
    model.name = As<std::string>(value, where);
  } else if (key == "beam_blocks_deg" || key == "beam_elevation_deg") {
    TVL_CHECK_INPUT(model.beam_elevation_rad.empty()) << where << ": the beams are given twice";
    model.beam_elevation_rad =
        key == "beam_blocks_deg" ? BeamBlocks(value, where) : BeamList(value, where);
  } else if (key == "rows") {
    const auto rows = As<std::string>(value, where);
    TVL_CHECK_INPUT(rows == "beams" || rows == "slices")
        << where << ": want beams or slices, is '" << rows << "'";
    model.rows_are_beams = rows == "beams";
  } else if (key == "ring_start_azimuth_deg") {
    model.ring_start_azimuth_rad = DegToRad(As<double>(value, where));
  } else if (key == "columns") {
    model.columns = As<int>(value, where);
  } else if (key == "sweep_s") {
    model.sweep_s = As<double>(value, where);
  } else if (key == "range_sigma_m") {
    model.range_sigma_m = As<double>(value, where);
  } else if (key == "min_range_m") {
    model.min_range_m = As<double>(value, where);
  } else if (key == "max_range_m") {
    model.max_range_m = As<double>(value, where);
  } else if (key == "vertical_correction_deg") {
    model.vertical_correction_rad = DegToRad(As<double>(value, where));
  } else {
    throw InputError(where + ": unknown key");
  }
  return model;
}

}  // namespace

LidarModel LidarOfSection(const YAML::Node& section, const std::string& source) {
  TVL_CHECK_INPUT(section.IsMap()) << Where(source, section, "lidar") << ": want a map";
  LidarModel model;
  for (const auto& entry : section) {
    const auto key = entry.first.as<std::string>();
    model = WithKey(model, key, entry.second, Where(source, entry.first, "lidar." + key));
  }
  try {
    model.Check();
  } catch (const InputError& e) {
    throw InputError(source + ": " + e.what());
  }
  return model;
}

LidarModel ParseProfile(const std::string& yaml, const std::string& source) {
  const YAML::Node root = ParseYaml(yaml, source);
  TVL_CHECK_INPUT(root.IsMap() && root["lidar"] && root["lidar"].IsMap())
      << source << ": a profile is a map with the key `lidar`";
  for (const auto& entry : root) {
    const auto key = entry.first.as<std::string>();
    TVL_CHECK_INPUT(key == "lidar") << Where(source, entry.first, key) << ": unknown key";
  }
  return LidarOfSection(root["lidar"], source);
}

LidarModel LoadProfile(const std::string& name) {
  for (const EmbeddedProfile& profile : EmbeddedProfiles()) {
    if (profile.name == name) return ParseProfile(profile.yaml, "profile " + name);
  }
  std::error_code ignored;
  if (std::filesystem::is_regular_file(name, ignored)) {
    return ParseProfile(ReadWholeText(name), name);
  }
  std::string known;
  for (const std::string& profile : ProfileNames()) known += (known.empty() ? "" : ", ") + profile;
  throw InputError("profile `" + name + "`: neither a file nor one of " + known);
}

std::vector<std::string> ProfileNames() {
  std::vector<std::string> names;
  for (const EmbeddedProfile& profile : EmbeddedProfiles()) names.push_back(profile.name);
  return names;
}

}  // namespace tvl
