#include "tvl/io/text_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "tvl/base/check.h"

namespace tvl {

std::vector<std::string> ReadLines(const std::string& path) {
  std::error_code ignored;
  std::ifstream file(path);
  TVL_CHECK_INPUT(file.good() && !std::filesystem::is_directory(path, ignored))
      << path << ": cannot be read";
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    lines.push_back(line);
  }
  while (!lines.empty() && lines.back().find_first_not_of(" \t") == std::string::npos) {
    lines.pop_back();
  }
  return lines;
}

std::vector<double> ParseNumbers(const std::string& text, const std::string& where) {
  std::vector<double> numbers;
  const char* const end = text.data() + text.size();
  for (const char* p = text.data();;) {
    while (p != end && (*p == ' ' || *p == '\t' || *p == ',')) ++p;
    if (p == end) return numbers;
    if (*p == '+') ++p;
    double value = 0.0;
    const auto [next, error] = std::from_chars(p, end, value);
    TVL_CHECK_INPUT(error == std::errc() && std::isfinite(value) &&
                    (next == end || *next == ' ' || *next == '\t' || *next == ','))
        << where << ": not a number: `" << std::string(p, end).substr(0, 40) << "`";
    numbers.push_back(value);
    p = next;
  }
}

Timestamp ParseSeconds(const std::string& text, const std::string& where) {
  constexpr double kMost_s = 9e9;  // 285 years: what 64 bits of nanoseconds hold
  const std::vector<double> numbers = ParseNumbers(text, where);
  TVL_CHECK_INPUT(numbers.size() == 1) << where << ": want one number, has " << numbers.size();
  TVL_CHECK_INPUT(std::abs(numbers[0]) < kMost_s)
      << where << ": want seconds, is " << numbers[0] << ": are these nanoseconds?";
  if (numbers[0] == 0.0) return {};
  // A number it is: [sign] digits with a point somewhere [e exponent].
  const size_t e = std::min(text.find_first_of("eE"), text.size());
  std::string digits;
  int64_t shift = 9 + (e < text.size() ? std::stoll(text.substr(e + 1)) : 0);  // of the point
  bool is_fraction = false;
  for (const char c : text.substr(0, e)) {
    is_fraction = is_fraction || c == '.';
    if (c < '0' || c > '9') continue;
    digits += c;
    shift -= is_fraction ? 1 : 0;
  }
  const int64_t kept = static_cast<int64_t>(digits.size()) + shift;
  if (kept < 0) return {};
  digits.resize(std::max(digits.size(), static_cast<size_t>(kept)) + 1, '0');
  const bool round_up = digits[static_cast<size_t>(kept)] >= '5';
  const int64_t ns = std::stoll("0" + digits.substr(0, static_cast<size_t>(kept))) + round_up;
  return {numbers[0] < 0.0 ? -ns : ns};
}

std::string LineOf(const std::string& path, size_t index) {
  return path + ":" + std::to_string(index + 1);
}

KeyedNumbers::KeyedNumbers(const std::string& path) : path_(path) {
  const std::vector<std::string> lines = ReadLines(path);
  for (size_t i = 0; i < lines.size(); ++i) {
    const size_t colon = lines[i].find(':');
    if (colon != std::string::npos) {
      entries_[lines[i].substr(0, colon)] = {lines[i].substr(colon + 1), i};
    }
  }
}

std::vector<double> KeyedNumbers::Get(const std::string& key, size_t count) const {
  const auto entry = entries_.find(key);
  TVL_CHECK_INPUT(entry != entries_.end()) << path_ << ": no line `" << key << ":`";
  const std::string where = LineOf(path_, entry->second.line) + ": " + key;
  const std::vector<double> numbers = ParseNumbers(entry->second.values, where);
  TVL_CHECK_INPUT(numbers.size() == count)
      << where << ": want " << count << " numbers, has " << numbers.size();
  return numbers;
}

}  // namespace tvl
