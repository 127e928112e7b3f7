// Text within bytes in memory: the headers of cloud files and their ascii points. Nothing is copied
// and nothing is believed: every number is checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tvl {

// The lines of a file whose bytes belong to somebody else.
class ByteLines {
 public:
  ByteLines(const uint8_t* data, size_t bytes);
  // The next line without its end (\n or \r\n); nothing at the end of the bytes.
  std::optional<std::string_view> Next();
  // Of the line that Next() gave last, counted from 1; 0 before the first.
  size_t line() const { return line_; }
  // Of the first byte after that line and its end.
  size_t offset() const { return offset_; }

 private:
  std::string_view text_;
  size_t offset_ = 0, line_ = 0;
};

// The words of a line, separated by blanks or tabs.
std::vector<std::string_view> Words(std::string_view line);

// At most 40 characters of a text that may hold anything, fit to be printed, between back quotes.
std::string Quoted(std::string_view text);

// A whole number from 0 to `most`. Throws InputError beginning with `where`.
size_t ParseCount(std::string_view word, size_t most, const std::string& where);

// A number as text, where "nan", "inf" and "-inf" are numbers: that is how clouds mark points
// without a return. Throws InputError beginning with `where`.
double ParseAnyNumber(std::string_view word, const std::string& where);

}  // namespace tvl
