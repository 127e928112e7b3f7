#include "tvl/io/cloud/stamps.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "tvl/base/check.h"
#include "tvl/io/cloud/file_names.h"
#include "tvl/io/kitti_times.h"
#include "tvl/io/text_file.h"

namespace tvl {
namespace {

struct Unit {
  const char* name;
  int exponent;  // a number of these is number * 10^exponent seconds
};
constexpr std::array<Unit, 4> kUnits = {
    {{"seconds", 0}, {"milliseconds", -3}, {"microseconds", -6}, {"nanoseconds", -9}}};

// Seconds from 1970 to the years 2000 and 2100: all recordings lie between.
constexpr double kYear2000_s = 946684800.0, kYear2100_s = 4102444800.0;
// Periods of lidars and cameras, 1 to 100 Hz, and a tenth for jitter.
constexpr double kLeastPeriod_s = 0.009, kMostPeriod_s = 1.1;
constexpr double kGrowingShare = 0.9;          // steps that must go forward
constexpr size_t kMostColumns = 8;             // looked at
constexpr uintmax_t kMostFileBytes = 1 << 26;  // 64 MiB: a day of stamps at 10 Hz

double Power(int exponent) { return std::pow(10.0, exponent); }

// `word` * 10^exponent seconds, exact to the nanosecond.
Timestamp ParseScaled(const std::string& word, int exponent, const std::string& where) {
  const size_t e = std::min(word.find_first_of("eE"), word.size());
  int own = 0;
  if (e < word.size()) {
    const char* begin = word.data() + e + 1;
    if (*begin == '+') ++begin;
    const auto [next, error] = std::from_chars(begin, word.data() + word.size(), own);
    TVL_CHECK_INPUT(error == std::errc() && std::abs(own) < 400)
        << where << ": exponent out of range: `" << word << "`";
  }
  return ParseSeconds(word.substr(0, e) + "e" + std::to_string(own + exponent), where);
}

// What the differences of the numbers are like.
struct Steps {
  double median = 0.0;  // of those that go forward; 0 without any
  double growing_share = 1.0;
  bool is_count = false;  // 0, 1, 2 and so on
  bool is_even = false;   // all equal
};

Steps StepsOf(const std::vector<double>& numbers) {
  Steps steps;
  if (numbers.size() < 2) return steps;
  std::vector<double> forward;
  steps.is_even = true;
  for (size_t i = 1; i < numbers.size(); ++i) {
    const double step = numbers[i] - numbers[i - 1];
    if (step > 0.0) forward.push_back(step);
    steps.is_even = steps.is_even && step == numbers[1] - numbers[0];
  }
  steps.is_count = steps.is_even && numbers[1] - numbers[0] == 1.0;
  steps.growing_share =
      static_cast<double>(forward.size()) / static_cast<double>(numbers.size() - 1);
  if (forward.empty()) return steps;
  const auto middle = forward.begin() + static_cast<std::ptrdiff_t>(forward.size() / 2);
  std::nth_element(forward.begin(), middle, forward.end());
  steps.median = *middle;
  return steps;
}

const Unit* UnitOfDate(double number) {
  for (const Unit& unit : kUnits) {
    const double s = number * Power(unit.exponent);
    if (s > kYear2000_s && s < kYear2100_s) return &unit;
  }
  return nullptr;
}

const Unit* UnitOfStep(double step) {
  for (const Unit& unit : kUnits) {
    const double s = step * Power(unit.exponent);
    if (s >= kLeastPeriod_s && s <= kMostPeriod_s) return &unit;
  }
  return nullptr;
}

std::string RateText(double period_s) {
  std::ostringstream out;
  out.precision(3);
  if (period_s > 0.0) out << ", " << 1.0 / period_s << " Hz";
  return out.str();
}

struct Choice {
  const Unit* unit = nullptr;  // null: none
  std::string what;
  bool is_since_1970 = false, is_doubtful = false;
};

Choice ChooseUnit(double first, const Steps& steps) {
  const Unit* const by_date = UnitOfDate(first);
  const Unit* const by_step = UnitOfStep(steps.median);
  if (steps.growing_share < kGrowingShare)
    return {nullptr, "the numbers do not increase", false, false};
  if (steps.is_count && by_date == nullptr) {
    return {nullptr, "the numbers count one by one: they are no times", false, false};
  }
  if (by_date == nullptr && by_step == nullptr) {
    return {nullptr, "in no unit are the numbers times at 1 to 100 Hz", false, false};
  }
  Choice choice;
  choice.unit = by_step != nullptr ? by_step : by_date;
  choice.is_since_1970 = choice.unit == by_date;
  choice.what = std::string(choice.unit->name) + (choice.is_since_1970 ? " since 1970" : "") +
                RateText(steps.median * Power(choice.unit->exponent));
  if (by_step == nullptr && steps.median > 0.0) {
    choice.what += " (by the date; the rate is unusual)";
  } else if (by_step != nullptr && by_date != nullptr && by_step != by_date) {
    choice.is_doubtful = true;
    choice.what +=
        " (doubtful: by the rate; as a date they would be " + std::string(by_date->name) + ")";
  }
  return choice;
}

std::vector<std::string> SplitColumns(const std::string& line) {
  std::vector<std::string> words;
  for (size_t begin = 0; (begin = line.find_first_not_of(" \t,;", begin)) != std::string::npos;) {
    const size_t end = std::min(line.find_first_of(" \t,;", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = end;
  }
  return words;
}

bool IsNumber(const std::string& word) {
  try {
    return ParseNumbers(word, "").size() == 1;
  } catch (const InputError&) {
    return false;
  }
}

// The rows of numbers of a file, split into columns.
std::vector<std::vector<std::string>> RowsOf(const std::vector<std::string>& lines) {
  std::vector<std::vector<std::string>> rows;
  bool has_names = false;
  for (const std::string& line : lines) {
    std::vector<std::string> words = SplitColumns(line);
    if (words.empty() || words[0][0] == '#') continue;
    if (rows.empty() && !has_names && std::none_of(words.begin(), words.end(), IsNumber)) {
      has_names = true;
      continue;
    }
    rows.push_back(std::move(words));
  }
  return rows;
}

StampsRead StampsOfRows(const std::vector<std::vector<std::string>>& rows,
                        const std::string& path) {
  StampsRead none;
  none.what = "no numbers";
  for (size_t column = 0; column < kMostColumns; ++column) {
    std::vector<std::string> words;
    for (const auto& row : rows) {
      if (column < row.size() && IsNumber(row[column])) words.push_back(row[column]);
    }
    if (words.empty() || words.size() < rows.size()) continue;
    StampsRead read = StampsOfNumbers(words, path);
    if (!read.stamps.empty()) {
      if (rows[0].size() > 1) read.what += ", column " + std::to_string(column + 1);
      return read;
    }
    none = read;
  }
  return none;
}

// StampsOfNumbers of words in any order: names whose fractions have different lengths come in
// another order than their times.
StampsRead StampsInOrder(const std::vector<std::string>& words, const std::string& where) {
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < words.size(); ++i) {
    order.emplace_back(ParseNumbers(words[i], where).at(0), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::string> sorted;
  for (const auto& entry : order) sorted.push_back(words[entry.second]);
  StampsRead read = StampsOfNumbers(sorted, where);
  if (read.stamps.empty()) return read;
  const std::vector<Timestamp> stamps = read.stamps;
  for (size_t k = 0; k < order.size(); ++k) read.stamps[order[k].second] = stamps[k];
  return read;
}

bool IsDate(const std::string& line) {
  constexpr size_t kDateLength = 10;  // 2011-09-26
  return line.size() > kDateLength && line[4] == '-' && line[7] == '-' &&
         line.find_first_not_of("0123456789") == 4;
}

}  // namespace

StampsRead StampsOfNumbers(const std::vector<std::string>& words, const std::string& where) {
  StampsRead read;
  read.what = "no numbers";
  if (words.empty()) return read;
  std::vector<double> numbers;
  for (const std::string& word : words) {
    const std::vector<double> one = ParseNumbers(word, where);
    TVL_CHECK_INPUT(one.size() == 1) << where << ": want one number, has " << one.size();
    numbers.push_back(one[0]);
  }
  const Choice choice = ChooseUnit(numbers[0], StepsOf(numbers));
  read.what = choice.what;
  read.is_since_1970 = choice.is_since_1970, read.is_doubtful = choice.is_doubtful;
  if (choice.unit == nullptr) return read;
  for (const std::string& word : words) {
    read.stamps.push_back(ParseScaled(word, choice.unit->exponent, where));
  }
  return read;
}

StampsRead ReadStampFile(const std::string& path) {
  try {
    std::error_code error;
    const uintmax_t size = std::filesystem::file_size(path, error);
    TVL_CHECK_INPUT(!error && size <= kMostFileBytes) << path << ": cannot be read, or too large";
    const std::vector<std::string> lines = ReadLines(path);
    if (!lines.empty() && IsDate(lines[0])) {
      return {ReadRawTimestamps(path), "dates, to the nanosecond", true, false};
    }
    return StampsOfRows(RowsOf(lines), path);
  } catch (const InputError& error) {
    return {{}, error.what(), false, false};
  }
}

StampsRead StampsFromFile(const std::string& path, const std::vector<std::string>& files) {
  StampsRead read = ReadStampFile(path);
  if (read.stamps.empty() || read.stamps.size() == files.size()) return read;
  // Any table has more lines than there are files; only a list of stamps goes by their numbers.
  const std::string name = std::filesystem::path(path).stem().string();
  const bool is_list =
      name.find("time") != std::string::npos || name.find("stamp") != std::string::npos;
  StampsRead by_number;
  by_number.what = read.what + ", by file number";
  by_number.is_since_1970 = read.is_since_1970, by_number.is_doubtful = read.is_doubtful;
  for (const std::string& file : files) {
    const std::optional<int64_t> number = FrameNumberOf(file);
    if (!is_list || !number || *number >= static_cast<int64_t>(read.stamps.size())) {
      return {{},
              std::to_string(read.stamps.size()) + " stamps for " + std::to_string(files.size()) +
                  " files: which belong to them is not told",
              false,
              false};
    }
    by_number.stamps.push_back(read.stamps[static_cast<size_t>(*number)]);
  }
  return by_number;
}

StampsRead StampsFromNames(const std::vector<std::string>& files) {
  StampsRead none;
  none.what = "file names do not end with a number";
  std::vector<std::string> words;
  std::string prefix;
  for (const std::string& file : files) {
    const std::optional<NameNumber> number = NumberOf(file);
    if (!number || (!words.empty() && number->prefix != prefix)) return none;
    prefix = number->prefix;
    words.push_back(number->text);
  }
  try {
    StampsRead read = StampsInOrder(words, "file names");
    if (read.is_since_1970 || read.stamps.empty()) return read;
    std::vector<double> times_ns;
    for (const Timestamp stamp : read.stamps) times_ns.push_back(static_cast<double>(stamp.ns));
    if (words.size() < 3 || StepsOf(times_ns).is_even) {
      none.what = "file names count in even steps: they may be frame numbers";
      return none;
    }
    return read;
  } catch (const InputError& error) {
    none.what = error.what();
    return none;
  }
}

}  // namespace tvl
