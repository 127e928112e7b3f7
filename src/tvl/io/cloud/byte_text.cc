#include "tvl/io/cloud/byte_text.h"

#include <algorithm>
#include <charconv>

#include "tvl/base/check.h"

namespace tvl {

ByteLines::ByteLines(const uint8_t* data, size_t bytes)
    : text_(reinterpret_cast<const char*>(data), bytes) {}

std::optional<std::string_view> ByteLines::Next() {
  if (offset_ >= text_.size()) return std::nullopt;
  const size_t end = std::min(text_.find('\n', offset_), text_.size());
  std::string_view line = text_.substr(offset_, end - offset_);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  offset_ = std::min(end + 1, text_.size());
  ++line_;
  return line;
}

std::vector<std::string_view> Words(std::string_view line) {
  std::vector<std::string_view> words;
  for (size_t begin = 0; begin < line.size();) {
    begin = line.find_first_not_of(" \t", begin);
    if (begin == std::string_view::npos) break;
    const size_t end = std::min(line.find_first_of(" \t", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = end;
  }
  return words;
}

std::string Quoted(std::string_view text) {
  std::string out(text.substr(0, 40));
  for (char& c : out) c = c >= ' ' && c <= '~' ? c : '?';
  return "`" + out + "`";
}

size_t ParseCount(std::string_view word, size_t most, const std::string& where) {
  size_t count = 0;
  const char* const end = word.data() + word.size();
  const auto [next, error] = std::from_chars(word.data(), end, count);
  TVL_CHECK_INPUT(error == std::errc() && next == end && count <= most)
      << where << ": want a whole number from 0 to " << most << ", is " << Quoted(word);
  return count;
}

double ParseAnyNumber(std::string_view word, const std::string& where) {
  std::string_view rest = word;
  if (!rest.empty() && rest.front() == '+') rest.remove_prefix(1);
  double value = 0.0;
  const char* const end = rest.data() + rest.size();
  const auto [next, error] = std::from_chars(rest.data(), end, value);
  TVL_CHECK_INPUT(error == std::errc() && next == end)
      << where << ": not a number: " << Quoted(word);
  return value;
}

}  // namespace tvl
