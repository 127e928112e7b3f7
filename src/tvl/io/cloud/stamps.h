// Time stamps of files whose unit nobody states: from a text file beside them or from their names.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tvl/base/time.h"

namespace tvl {

struct StampsRead {
  std::vector<Timestamp> stamps;  // empty: none could be made out
  // What they are, e.g. "seconds since 1970, 10 Hz"; or why there are none.
  std::string what;
  bool is_since_1970 = false;
  bool is_doubtful = false;  // another unit makes sense as well; `what` says which
};

// Stamps from decimal numbers, every digit kept to the nanosecond. The unit is the one (s, ms, us,
// ns) in which the numbers are a date from 2000 to 2100 or step at 1 to 100 Hz; where these two
// disagree the steps decide, and `what` says that it is doubtful. No stamps: numbers that mostly do
// not increase or that count 0, 1, 2, or where no unit makes sense. Words must be decimal numbers:
// throws InputError beginning with `where` otherwise.
StampsRead StampsOfNumbers(const std::vector<std::string>& words, const std::string& where);

// Stamps from a text file: one number a line, or columns separated by blanks, commas or semicolons
// of which the first that makes sense is taken, or dates as KITTI raw has them. Comments (#), empty
// lines and a line of column names are passed over. Never throws for bad content: `what` says why.
StampsRead ReadStampFile(const std::string& path);

// Stamps of `files` from one of those text files: by position where there are as many, by frame
// number where there are more.
StampsRead StampsFromFile(const std::string& path, const std::vector<std::string>& files);

// Stamps from numbers in the file names; they must be since 1970 or step unevenly, because even
// steps such as 0, 10, 20 may as well be chosen frames.
StampsRead StampsFromNames(const std::vector<std::string>& files);

}  // namespace tvl
