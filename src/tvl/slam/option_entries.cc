#include "tvl/slam/option_entries.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "tvl/base/check.h"

namespace tvl {
namespace {

// The root of the text; null if there is nothing but comments.
YAML::Node ParseText(const std::string& yaml, const std::string& source) {
  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(yaml);
  } catch (const YAML::ParserException& e) {
    throw InputError(AtLine(source, e.mark.line + 1) + e.msg);
  }
  if (documents.empty()) return YAML::Node();
  TVL_CHECK_INPUT(documents.size() == 1) << source << ": holds more than one YAML document";
  TVL_CHECK_INPUT(documents[0].IsMap() || documents[0].IsNull())
      << source << ": options are written as `key: value`";
  return documents[0];
}

// Options nest less deep; an alias that holds itself nests for ever.
constexpr int kMaxDepth = 16;

// The entries of a section and of those below it. Empty sections give an entry without value.
std::vector<OptionEntry> Flatten(const YAML::Node& section, const std::string& prefix,
                                 const std::string& source, int depth = 0) {
  TVL_CHECK_INPUT(depth < kMaxDepth)
      << AtLine(source, section.Mark().line + 1) << "nests too deeply";
  std::vector<OptionEntry> entries;
  for (const auto& pair : section) {
    const int line = pair.first.Mark().line + 1;
    TVL_CHECK_INPUT(pair.first.IsScalar()) << AtLine(source, line) << "a key is a word";
    const std::string key = prefix + pair.first.Scalar();
    if (pair.second.IsMap() && pair.second.size() > 0) {
      const auto below = Flatten(pair.second, key + ".", source, depth + 1);
      entries.insert(entries.end(), below.begin(), below.end());
    } else {
      entries.push_back({key, pair.second, line});
    }
  }
  return entries;
}

// Least number of letters to change, put in or leave out (Levenshtein).
size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t changed = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

std::string LastPart(const std::string& key) { return key.substr(key.rfind('.') + 1); }

// ", did you mean ...?", or nothing where no known key is like it: a few letters off, or the right
// name in the wrong section.
std::string Suggestion(const std::string& key, const KnownKeys& known) {
  std::vector<std::string> candidates = known.values;
  candidates.insert(candidates.end(), known.sections.begin(), known.sections.end());
  std::string best;
  size_t best_distance = std::numeric_limits<size_t>::max();
  const size_t near = std::max<size_t>(2, LastPart(key).size() / 3);
  for (const std::string& candidate : candidates) {
    const size_t distance = EditDistance(key, candidate);
    const bool is_like = distance <= near || LastPart(candidate) == LastPart(key);
    if (!is_like || distance >= best_distance) continue;
    best_distance = distance;
    best = candidate;
  }
  return best.empty() ? "" : ", did you mean `" + best + "`?";
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The entries by key; refuses what cannot be set and what is set twice.
OptionEntries KnownEntries(const std::vector<OptionEntry>& given, const std::string& source,
                           const KnownKeys& known) {
  OptionEntries entries;
  for (const OptionEntry& entry : given) {
    const std::string where = AtLine(source, entry.line) + entry.key + ": ";
    if (Contains(known.sections, entry.key)) {
      TVL_CHECK_INPUT(!entry.value.IsScalar() && !entry.value.IsSequence())
          << where << "is a section, its options belong below it";
      continue;
    }
    TVL_CHECK_INPUT(Contains(known.values, entry.key))
        << where << "unknown key" << Suggestion(entry.key, known);
    const auto [earlier, is_new] = entries.emplace(entry.key, entry);
    TVL_CHECK_INPUT(is_new) << where << "given twice, first in line " << earlier->second.line;
  }
  return entries;
}

}  // namespace

std::string AtLine(const std::string& source, int line) {
  return source + ":" + std::to_string(line) + ": ";
}

OptionEntries ReadEntries(const std::string& yaml, const std::string& source,
                          const KnownKeys& known) {
  return KnownEntries(Flatten(ParseText(yaml, source), "", source), source, known);
}

}  // namespace tvl
