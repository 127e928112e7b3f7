// Text files of numbers, with errors that name file and line.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tvl/base/time.h"

namespace tvl {

// The lines of a file without their ends; empty lines at the end of the file are dropped.
// Throws InputError if the file cannot be read.
std::vector<std::string> ReadLines(const std::string& path);

// The numbers of a line, separated by blanks. Throws InputError beginning with `where` for
// anything that is not a finite number.
std::vector<double> ParseNumbers(const std::string& text, const std::string& where);

// One decimal number of seconds, digit by digit: a double cannot tell the nanoseconds of a stamp
// that counts from 1970. Throws InputError beginning with `where`.
Timestamp ParseSeconds(const std::string& text, const std::string& where);

// "path:line" with lines counted from 1, as compilers write it.
std::string LineOf(const std::string& path, size_t index);

// A file of "key: values" lines, e.g. a KITTI calibration.
class KeyedNumbers {
 public:
  explicit KeyedNumbers(const std::string& path);
  bool Has(const std::string& key) const { return entries_.count(key) > 0; }
  // The `count` numbers of `key`. Throws InputError naming file, line and key.
  std::vector<double> Get(const std::string& key, size_t count) const;
  const std::string& path() const { return path_; }

 private:
  struct Entry {
    std::string values;
    size_t line;
  };
  std::string path_;
  std::map<std::string, Entry> entries_;
};

}  // namespace tvl
