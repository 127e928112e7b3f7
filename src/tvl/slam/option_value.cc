#include "tvl/slam/option_value.h"

#include <charconv>
#include <cmath>
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

double ToInternal(double value, bool is_angle) { return is_angle ? DegToRad(value) : value; }

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

// The value as written, with as few digits as still give the same value when read.
double RoundedAsFarAsPossible(double value, bool is_angle) {
  const double written = is_angle ? RadToDeg(value) : value;
  constexpr int kMaxDigits = 17;
  for (int digits = 1; digits < kMaxDigits; ++digits) {
    char text[40];
    const auto end =
        std::to_chars(text, std::end(text), written, std::chars_format::general, digits).ptr;
    double read = 0.0;
    std::from_chars(text, end, read);
    if (ToInternal(read, is_angle) == value) return read;
  }
  return written;
}

// All digits that tell the number from its neighbours; exponents only for the very small and large.
std::string Shortest(double value) {
  const double size = std::abs(value);
  const bool is_plain = value == 0.0 || (size >= 1e-4 && size < 1e7);
  char text[40];
  const auto end =
      std::to_chars(text, std::end(text), value,
                    is_plain ? std::chars_format::fixed : std::chars_format::scientific)
          .ptr;
  return {text, end};
}

}  // namespace

bool IsAngleField(const std::string& field) { return AngleUnitAt(field) != std::string::npos; }

std::string KeyOfField(const std::string& field) {
  const size_t at = AngleUnitAt(field);
  return at == std::string::npos ? field : std::string(field).replace(at, kSuffixLength, "_deg");
}

std::string NumberText(double value, bool is_angle) {
  return WithPoint(Shortest(RoundedAsFarAsPossible(value, is_angle)));
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
  return ToInternal(value, is_angle);
}

std::string WordFromNode(const YAML::Node& node, const std::string& where) {
  return Converted<std::string>(node, "a word", where);
}

std::vector<YAML::Node> ListFromNode(const YAML::Node& node, const std::string& where) {
  TVL_CHECK_INPUT(node.IsSequence()) << where << ": want a list, " << Found(node);
  return {node.begin(), node.end()};
}

}  // namespace tvl
