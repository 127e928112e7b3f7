#include "tvl/slam/option_value.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "tvl/base/units.h"

namespace tvl {
namespace {

constexpr char kRadians[] = "_rad";
constexpr size_t kSuffixLength = 4;

// Where the unit of an angle stands in a field's name; npos if it is none. Squares stay radians.
size_t AngleUnitAt(const std::string& field) {
  const size_t at = field.rfind(kRadians);
  if (at == std::string::npos) return at;
  const std::string rest = field.substr(at + kSuffixLength);
  return rest.empty() || rest.rfind("_per_", 0) == 0 ? at : std::string::npos;
}

// Digits a double is read from at most; texts with more are meant to the bit.
constexpr int kDoubleDigits = 17;
constexpr int kLongDigits = 21;
constexpr long double kRadPerDeg = 3.14159265358979323846L / 180.0L;

int SignificantDigits(const std::string& text) {
  const std::string mantissa = text.substr(0, text.find_first_of("eE"));
  const size_t first = std::min(mantissa.find_first_of("123456789"), mantissa.size());
  return static_cast<int>(std::count_if(mantissa.begin() + static_cast<std::ptrdiff_t>(first),
                                        mantissa.end(),
                                        [](char c) { return c >= '0' && c <= '9'; }));
}

// A number of degrees in radians. Doubles in degrees do not reach every double in radians (they lie
// more sparsely in places), so more digits than a double has are taken into account.
double AngleFromText(const std::string& text, double value_deg) {
  if (SignificantDigits(text) <= kDoubleDigits) return DegToRad(value_deg);
  return static_cast<double>(std::strtold(text.c_str(), nullptr) * kRadPerDeg);
}

// What was found instead of the wanted kind.
std::string Found(const YAML::Node& node) {
  if (node.IsScalar()) return "is `" + node.Scalar() + "`";
  if (node.IsSequence()) return "is a list";
  return node.IsMap() ? "is a section" : "has no value";
}

template <typename T>
T Converted(const YAML::Node& node, const char* wanted, const std::string& where) {
  try {
    return node.as<T>();
  } catch (const YAML::Exception&) {
    throw InputError(where + ": want " + wanted + ", " + Found(node));
  }
}

// Like 12.0 or 1.0e-06: readers of YAML 1.1 take 12 for an integer and 1e-06 for a word.
std::string WithPoint(std::string digits) {
  if (digits.find('.') != std::string::npos) return digits;
  return digits.insert(std::min(digits.find('e'), digits.size()), ".0");
}

// A number as short as possible; exponents only for the very small and large.
std::string Shortest(double value) {
  const double size = std::abs(value);
  const bool is_plain = value == 0.0 || (size >= 1e-4 && size < 1e7);
  const auto format = is_plain ? std::chars_format::fixed : std::chars_format::scientific;
  char text[40];
  return {text, std::to_chars(text, std::end(text), value, format).ptr};
}

// The degrees that give back `value_rad`.
std::string AngleText(double value_rad) {
  char text[40];
  for (int digits = 1; digits <= kDoubleDigits; ++digits) {
    const auto end =
        std::to_chars(text, std::end(text), RadToDeg(value_rad), std::chars_format::general, digits)
            .ptr;
    double value_deg = 0.0;
    std::from_chars(text, end, value_deg);
    if (DegToRad(value_deg) == value_rad) return Shortest(value_deg);
  }
  const long double value_deg = static_cast<long double>(value_rad) / kRadPerDeg;
  return {
      text,
      std::to_chars(text, std::end(text), value_deg, std::chars_format::general, kLongDigits).ptr};
}

}  // namespace

bool IsAngleField(const std::string& field) { return AngleUnitAt(field) != std::string::npos; }

std::string KeyOfField(const std::string& field) {
  const size_t at = AngleUnitAt(field);
  return at == std::string::npos ? field : std::string(field).replace(at, kSuffixLength, "_deg");
}

std::string NumberText(double value, bool is_angle) {
  return WithPoint(is_angle ? AngleText(value) : Shortest(value));
}

bool BoolFromNode(const YAML::Node& node, const std::string& where) {
  return Converted<bool>(node, "true or false", where);
}

int IntFromNode(const YAML::Node& node, const std::string& where) {
  return Converted<int>(node, "a whole number", where);
}

double NumberFromNode(const YAML::Node& node, bool is_angle, const std::string& where) {
  const double value = Converted<double>(node, "a number", where);
  TVL_CHECK_INPUT(std::isfinite(value)) << where << ": want a finite number, " << Found(node);
  return is_angle ? AngleFromText(node.Scalar(), value) : value;
}

std::string WordFromNode(const YAML::Node& node, const std::string& where) {
  return Converted<std::string>(node, "a word", where);
}

std::vector<YAML::Node> ListFromNode(const YAML::Node& node, const std::string& where) {
  TVL_CHECK_INPUT(node.IsSequence()) << where << ": want a list, " << Found(node);
  return {node.begin(), node.end()};
}

}  // namespace tvl
