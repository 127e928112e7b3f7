#include "tvl/io/cloud/file_names.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>

namespace tvl {
namespace {

namespace fs = std::filesystem;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

std::string LowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// The digits from `begin` on, without leading zeros; `*end` is set behind them.
std::string_view DigitsAt(const std::string& text, size_t begin, size_t* end) {
  *end = begin;
  while (*end < text.size() && IsDigit(text[*end])) ++*end;
  while (begin + 1 < *end && text[begin] == '0') ++begin;
  return std::string_view(text).substr(begin, *end - begin);
}

// "1317376000_123456789" as seconds and nanoseconds; nothing for other names.
std::optional<NameNumber> SecondsAndNanoseconds(const std::string& stem) {
  constexpr size_t kSecondsDigits = 10, kNanosecondsDigits = 9;  // of stamps from 2001 to 2286
  constexpr size_t kDigits = kSecondsDigits + 1 + kNanosecondsDigits;
  if (stem.size() < kDigits) return std::nullopt;
  std::string text = stem.substr(stem.size() - kDigits);
  const char separator = text[kSecondsDigits];
  const std::string prefix = stem.substr(0, stem.size() - kDigits);
  if ((separator != '_' && separator != '-') || (!prefix.empty() && IsDigit(prefix.back()))) {
    return std::nullopt;
  }
  text[kSecondsDigits] = '.';
  const auto digits = std::count_if(text.begin(), text.end(), IsDigit);
  if (digits + 1 != static_cast<std::ptrdiff_t>(kDigits)) return std::nullopt;
  return NameNumber{prefix, text};
}

}  // namespace

bool NaturalLess(const std::string& a, const std::string& b) {
  size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (IsDigit(a[i]) && IsDigit(b[j])) {
      const std::string_view m = DigitsAt(a, i, &i), n = DigitsAt(b, j, &j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  if ((i < a.size()) != (j < b.size())) return j < b.size();
  return a < b;  // 7 and 007
}

std::vector<std::string> ListFiles(const fs::path& folder,
                                   const std::vector<std::string>& extensions) {
  std::vector<std::string> paths;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const fs::path& path = it->path();
    const std::string extension = ExtensionOf(path.string());
    if (path.filename().string().front() == '.') continue;
    if (std::count(extensions.begin(), extensions.end(), extension) == 0) continue;
    std::error_code ignored;
    if (it->is_regular_file(ignored)) paths.push_back(path.string());
  }
  std::sort(paths.begin(), paths.end(), NaturalLess);
  return paths;
}

std::string ExtensionOf(const std::string& path) {
  return LowerCase(fs::path(path).extension().string());
}

std::string StemOf(const std::string& path) {
  const fs::path stem = fs::path(path).stem();
  const std::string second = LowerCase(stem.extension().string());
  const bool is_cloud = second == ".pcd" || second == ".ply" || second == ".las";
  return is_cloud ? stem.stem().string() : stem.string();
}

std::optional<NameNumber> NumberOf(const std::string& path) {
  const std::string stem = StemOf(path);
  if (auto number = SecondsAndNanoseconds(stem)) return number;
  size_t begin = stem.size();
  bool has_point = false;
  while (begin > 0) {
    const bool is_point = stem[begin - 1] == '.' && !has_point && begin < stem.size() &&
                          begin >= 2 && IsDigit(stem[begin - 2]);
    if (!IsDigit(stem[begin - 1]) && !is_point) break;
    has_point = has_point || is_point;
    --begin;
  }
  if (begin == stem.size()) return std::nullopt;
  return NameNumber{stem.substr(0, begin), stem.substr(begin)};
}

std::optional<int64_t> FrameNumberOf(const std::string& path) {
  const std::optional<NameNumber> number = NumberOf(path);
  if (!number || number->text.size() > 18 || number->text.find('.') != std::string::npos) {
    return std::nullopt;
  }
  return std::stoll(number->text);
}

std::vector<std::string> PairByName(const std::vector<std::string>& scans,
                                    const std::vector<std::string>& images) {
  std::map<std::string, std::string> by_stem;
  std::map<int64_t, std::string> by_number;
  for (const std::string& image : images) {
    by_stem[StemOf(image)] = image;
    if (const auto number = FrameNumberOf(image)) by_number[*number] = image;
  }
  std::vector<std::string> pairs;
  for (const std::string& scan : scans) {
    std::string pair;
    const auto same = by_stem.find(StemOf(scan));
    if (same != by_stem.end()) {
      pair = same->second;
    } else if (const auto number = FrameNumberOf(scan)) {
      const auto numbered = by_number.find(*number);
      if (numbered != by_number.end()) pair = numbered->second;
    }
    pairs.push_back(pair);
  }
  return pairs;
}

std::string NameOfFolder(const std::string& path) {
  const fs::path full = fs::absolute(path).lexically_normal();
  return (full.has_filename() ? full : full.parent_path()).filename().string();
}

}  // namespace tvl
