// The files that come with the program: config/*.yaml load, docs/options.md is complete and right.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tvl/base/units.h"
#include "tvl/slam/options_io.h"

namespace tvl {
namespace {

TEST(OptionsManual, ShippedConfigsLoad) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TVL_SOURCE_DIR "/config")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_NO_THROW(LoadOptions(entry.path().string())) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 1);
}

TEST(OptionsManual, PaperConfigSaysWhatThePaperSays) {
  const RunOptions paper = LoadOptions(TVL_SOURCE_DIR "/config/paper.yaml");
  EXPECT_EQ(paper.slam.mapping.interval, 5);                                           // 5.2: 2 Hz
  EXPECT_DOUBLE_EQ(paper.slam.preprocessing.depth.min_incidence_rad, DegToRad(10.0));  // 4.4.4
  EXPECT_GE(paper.slam.preprocessing.depth.least_squares_points, 1000);                // 4.4.3
  EXPECT_EQ(paper.slam.preprocessing.depth.max_depth_m, 50.0);                         // 4.4.4
  EXPECT_EQ(paper.slam.preprocessing.vision.max_features, 300);                        // 4.1
  EXPECT_FALSE(paper.slam.mapping.scan_to_map.use_camera);                             // 5.2
  EXPECT_FALSE(paper.slam.loops.use_lidar);                                            // 6.2
  EXPECT_EQ(paper.slam.loops.polish.loop_loss, LoopLoss::kHuber);                      // 6.3
}

// The words in backticks of a line.
std::vector<std::string> Quoted(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream parts(line);
  std::string part;
  for (bool inside = false; std::getline(parts, part, '`'); inside = !inside) {
    if (inside) words.push_back(part);
  }
  return words;
}

struct DocumentedOption {
  std::string key, value;
};

// The rows | `option` | default | ... of docs/options.md below headings ## `section`, `section`.
std::vector<DocumentedOption> DocumentedOptions() {
  std::ifstream file(TVL_SOURCE_DIR "/docs/options.md");
  EXPECT_TRUE(file.good());
  std::vector<DocumentedOption> options;
  std::vector<std::string> prefixes;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("## ", 0) == 0) {
      prefixes = Quoted(line);
      for (std::string& prefix : prefixes) prefix += ".";
      if (prefixes.empty()) prefixes = {""};
    }
    if (line.rfind("| `", 0) != 0) continue;
    const size_t begin = line.find("| ", 2) + 2;
    const std::string value = line.substr(begin, line.find(" |", begin) - begin);
    for (const std::string& prefix : prefixes) options.push_back({prefix + Quoted(line)[0], value});
  }
  return options;
}

// True if the manual's value is the default: to the letter, or as a number rounded to 0.1 %.
bool SaysTheSame(const YAML::Node& documented, const YAML::Node& actual) {
  if (documented.IsSequence() && actual.IsSequence() && documented.size() == actual.size()) {
    for (size_t i = 0; i < actual.size(); ++i) {
      if (!SaysTheSame(documented[i], actual[i])) return false;
    }
    return true;
  }
  if (!documented.IsScalar() || !actual.IsScalar()) return false;
  if (documented.Scalar() == actual.Scalar()) return true;
  try {
    const double value = actual.as<double>();
    return std::abs(documented.as<double>() - value) <= 1e-3 * std::abs(value);
  } catch (const YAML::Exception&) {
    return false;
  }
}

YAML::Node ValueAt(YAML::Node node, const std::string& key) {
  std::istringstream parts(key);
  for (std::string part; std::getline(parts, part, '.');) node.reset(node[part]);
  return node;
}

TEST(OptionsManual, ManualHasEveryOptionOnce) {
  std::multiset<std::string> documented;
  for (const DocumentedOption& option : DocumentedOptions()) documented.insert(option.key);
  for (const std::string& key : OptionKeys()) {
    EXPECT_EQ(documented.count(key), 1u) << "docs/options.md: rows of " << key;
    documented.erase(key);
  }
  EXPECT_THAT(documented, ::testing::IsEmpty()) << "docs/options.md: no such options";
}

TEST(OptionsManual, ManualSaysTheDefaults) {
  const YAML::Node defaults = YAML::Load(DumpOptions({}));
  for (const DocumentedOption& option : DocumentedOptions()) {
    const YAML::Node actual = ValueAt(defaults, option.key);
    if (!actual.IsDefined()) continue;  // told by the test above
    EXPECT_TRUE(SaysTheSame(YAML::Load(option.value), actual))
        << "docs/options.md: " << option.key << ": says " << option.value << ", the default is "
        << actual;
  }
}

}  // namespace
}  // namespace tvl
