#include "tvl/io/kitti_times.h"

#include <cstdio>

#include "tvl/base/check.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

// Days from 1970-01-01 to a date of the Gregorian calendar.
int64_t DaysSinceEpoch(int year, int month, int day) {
  // Years begin in March here, so that the leap day comes last.
  const int64_t y = month > 2 ? year : year - 1, m = month > 2 ? month - 3 : month + 9;
  const int64_t days_of_months = (153 * m + 2) / 5;
  const int64_t days_to_epoch = 719468;  // from 0000-03-01
  return 365 * y + y / 4 - y / 100 + y / 400 + days_of_months + day - 1 - days_to_epoch;
}

// "964389445", "964" or "" as nanoseconds.
int64_t FractionNs(std::string digits) {
  digits.resize(9, '0');
  return std::stoll(digits);
}

Timestamp ParseRawTimestamp(const std::string& line, const std::string& where) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, used = 0;
  const int fields = std::sscanf(line.c_str(), "%4d-%2d-%2d %2d:%2d:%2d%n", &year, &month, &day,
                                 &hour, &minute, &second, &used);
  TVL_CHECK_INPUT(fields == 6 && month >= 1 && month <= 12 && day >= 1 && day <= 31)
      << where << ": want `YYYY-MM-DD HH:MM:SS.nnnnnnnnn`, is `" << line << "`";
  const std::string rest = line.substr(static_cast<size_t>(used));
  const std::string digits = rest.empty() ? rest : rest.substr(1);
  TVL_CHECK_INPUT((rest.empty() || rest[0] == '.') &&
                  digits.find_first_not_of("0123456789") == std::string::npos)
      << where << ": want a fraction of a second, is `" << rest << "`";
  const int64_t seconds =
      ((DaysSinceEpoch(year, month, day) * 24 + hour) * 60 + minute) * 60 + second;
  return {seconds * 1000000000 + FractionNs(digits)};
}

}  // namespace

std::vector<Timestamp> ReadOdometryTimes(const std::string& path) {
  std::vector<Timestamp> stamps;
  const std::vector<std::string> lines = ReadLines(path);
  for (size_t i = 0; i < lines.size(); ++i) {
    stamps.push_back(ParseSeconds(lines[i], LineOf(path, i)));
  }
  return stamps;
}

std::vector<Timestamp> ReadRawTimestamps(const std::string& path) {
  std::vector<Timestamp> stamps;
  const std::vector<std::string> lines = ReadLines(path);
  for (size_t i = 0; i < lines.size(); ++i) {
    stamps.push_back(ParseRawTimestamp(lines[i], LineOf(path, i)));
  }
  return stamps;
}

}  // namespace tvl
