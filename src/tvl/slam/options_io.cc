#include "tvl/slam/options_io.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "tvl/slam/option_entries.h"
#include "tvl/slam/option_value.h"
#include "tvl/slam/options_fields.h"

namespace tvl {
namespace {

class KeyCollector {
 public:
  KeyCollector(std::string prefix, KnownKeys& known) : prefix_(std::move(prefix)), known_(known) {}
  template <typename T>
  void operator()(const char* name, T& field) {
    const std::string key = prefix_ + KeyOfField(name);
    if constexpr (kIsSection<T>) {
      known_.sections.push_back(key);
      KeyCollector inner(key + ".", known_);
      VisitFields(inner, field);
    } else {
      known_.values.push_back(key);
    }
  }

 private:
  std::string prefix_;
  KnownKeys& known_;
};

KnownKeys CollectKeys() {
  KnownKeys known;
  RunOptions options;
  KeyCollector collector("", known);
  VisitFields(collector, options);
  return known;
}

// Sets the fields that have an entry.
class Setter {
 public:
  Setter(std::string prefix, const std::string& source, const OptionEntries& entries)
      : prefix_(std::move(prefix)), source_(source), entries_(entries) {}
  template <typename T>
  void operator()(const char* name, T& field) {
    const std::string key = prefix_ + KeyOfField(name);
    if constexpr (kIsSection<T>) {
      Setter inner(key + ".", source_, entries_);
      VisitFields(inner, field);
    } else if (const auto found = entries_.find(key); found != entries_.end()) {
      const OptionEntry& entry = found->second;
      field = ValueFromNode<T>(entry.value, IsAngleField(name), AtLine(source_, entry.line) + key);
    }
  }

 private:
  std::string prefix_;
  const std::string& source_;
  const OptionEntries& entries_;
};

template <typename T, typename = void>
struct HasCheck : std::false_type {};
template <typename T>
struct HasCheck<T, std::void_t<decltype(std::declval<const T&>().Check())>> : std::true_type {};

// Calls Check() of every section, the innermost first: so a complaint is known to be about this
// section, and its line is found where the file has one.
class Checker {
 public:
  Checker(std::string prefix, const std::string& source, const OptionEntries& entries)
      : prefix_(std::move(prefix)), source_(source), entries_(entries) {}
  template <typename T>
  void operator()(const char* name, T& field) {
    if constexpr (kIsSection<T>) {
      Checker inner(prefix_ + name + ".", source_, entries_);
      VisitFields(inner, field);
      inner.CheckOwn(field);
    }
  }
  template <typename T>
  void CheckOwn(const T& options) const {
    if constexpr (HasCheck<T>::value) {
      try {
        options.Check();
      } catch (const InputError& e) {
        throw InputError(Located(e.what()));
      }
    }
  }

 private:
  // Complaints begin with the field, by one name or another: "min_points: must be positive",
  // "clusters.min_angle_deg: want ...".
  std::string Located(const std::string& complaint) const {
    const std::string named = KeyOfField(complaint.substr(0, complaint.find_first_of(":, ")));
    auto found = entries_.find(prefix_ + named);
    if (found == entries_.end()) {
      found = entries_.find(prefix_ + named.substr(named.rfind('.') + 1));
    }
    const std::string where =
        found == entries_.end() ? source_ + ": " : AtLine(source_, found->second.line);
    if (prefix_.empty()) return where + complaint;
    return where + prefix_.substr(0, prefix_.size() - 1) + ": " + complaint;
  }

  std::string prefix_;
  const std::string& source_;
  const OptionEntries& entries_;
};

class Dumper {
 public:
  Dumper(int depth, std::ostream& out) : depth_(depth), out_(out) {}
  template <typename T>
  void operator()(const char* name, T& field) {
    out_ << std::string(static_cast<size_t>(2 * depth_), ' ') << KeyOfField(name) << ":";
    if constexpr (kIsSection<T>) {
      out_ << "\n";
      Dumper inner(depth_ + 1, out_);
      VisitFields(inner, field);
    } else {
      out_ << " " << ValueText(field, IsAngleField(name)) << "\n";
    }
  }

 private:
  int depth_;
  std::ostream& out_;
};

}  // namespace

RunOptions ApplyYaml(const std::string& yaml, const std::string& source, const RunOptions& base) {
  const OptionEntries entries = ReadEntries(yaml, source, CollectKeys());
  RunOptions options = base;
  Setter setter("", source, entries);
  VisitFields(setter, options);
  Checker checker("", source, entries);
  VisitFields(checker, options);
  checker.CheckOwn(options);
  return options;
}

RunOptions LoadOptions(const std::string& path, const RunOptions& base) {
  std::ifstream file(path);
  TVL_CHECK_INPUT(file.good() && !std::filesystem::is_directory(path))
      << path << ": cannot be read";
  std::ostringstream text;
  text << file.rdbuf();
  return ApplyYaml(text.str(), path, base);
}

std::string DumpOptions(const RunOptions& options) {
  RunOptions copy = options;  // fields are visited as mutable
  std::ostringstream out;
  Dumper dumper(0, out);
  VisitFields(dumper, copy);
  return out.str();
}

std::vector<std::string> OptionKeys() { return CollectKeys().values; }

}  // namespace tvl
