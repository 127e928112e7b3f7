// Values of options as YAML writes them.
//
// Angles are degrees in YAML and radians in the code: a field `slope_rad` has the key `slope_deg`,
// `drift_rad_per_m` the key `drift_deg_per_m`. Other units stay as the name says.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <type_traits>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/slam/option_words.h"

namespace tvl {

// A struct of options, to be walked field by field, rather than a value.
template <typename T>
inline constexpr bool kIsSection = std::is_class_v<T>&& std::is_aggregate_v<T>;

// The key of a field; and whether its numbers are angles, converted on the way in and out.
std::string KeyOfField(const std::string& field);
bool IsAngleField(const std::string& field);

// As few digits as give back the same bits when read; always told apart from an integer. An angle
// comes in radians and is written in degrees.
std::string NumberText(double value, bool is_angle);

// The value of a node. Throw InputError beginning with `where` when it is of another kind or not
// finite.
bool BoolFromNode(const YAML::Node& node, const std::string& where);
int IntFromNode(const YAML::Node& node, const std::string& where);
double NumberFromNode(const YAML::Node& node, bool is_angle, const std::string& where);
std::string WordFromNode(const YAML::Node& node, const std::string& where);
std::vector<YAML::Node> ListFromNode(const YAML::Node& node, const std::string& where);

// The text of any option's value, and the way back.
template <typename T>
std::string ValueText(const T& value, bool is_angle) {
  if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::is_same_v<T, int>) {
    return std::to_string(value);
  } else if constexpr (std::is_same_v<T, double>) {
    return NumberText(value, is_angle);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return '"' + value + '"';
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    std::string text;
    for (const double v : value) text += (text.empty() ? "" : ", ") + NumberText(v, is_angle);
    return "[" + text + "]";
  } else {
    for (const auto& [word, meaning] : WordsOf(value)) {
      if (meaning == value) return word;
    }
    throw Error("an enumeration has a value without a word");
  }
}

template <typename T>
T ValueFromNode(const YAML::Node& node, bool is_angle, const std::string& where) {
  if constexpr (std::is_same_v<T, bool>) {
    return BoolFromNode(node, where);
  } else if constexpr (std::is_same_v<T, int>) {
    return IntFromNode(node, where);
  } else if constexpr (std::is_same_v<T, double>) {
    return NumberFromNode(node, is_angle, where);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return WordFromNode(node, where);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    std::vector<double> values;
    for (const YAML::Node& element : ListFromNode(node, where)) {
      values.push_back(NumberFromNode(element, is_angle, where));
    }
    return values;
  } else {
    const std::string given = WordFromNode(node, where);
    std::string known;
    for (const auto& [word, meaning] : WordsOf(T{})) {
      if (given == word) return meaning;
      known += (known.empty() ? "" : ", ") + std::string(word);
    }
    throw InputError(where + ": want one of " + known + ", is `" + given + "`");
  }
}

}  // namespace tvl
