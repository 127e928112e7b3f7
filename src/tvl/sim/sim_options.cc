#include "tvl/sim/sim_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <functional>
#include <map>
#include <sstream>
#include <type_traits>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

constexpr std::array<const char*, 9> kPresets = {
    "city", "loop", "reverse", "traffic", "aliasing", "nightloop", "lateloop", "tunnel", "open"};
constexpr const char* kPrefix = "sim:";

template <typename T>
T ParseNumber(const std::string& text, const std::string& field) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  TVL_CHECK_INPUT(error == std::errc() && end == text.data() + text.size())
      << field << ": want a " << (std::is_integral_v<T> ? "whole " : "") << "number, got '" << text
      << "'";
  return value;
}

bool ParseFlag(const std::string& text, const std::string& field) {
  TVL_CHECK_INPUT(text == "0" || text == "1") << field << ": want 0 or 1, got '" << text << "'";
  return text == "1";
}

void CheckRange(const FrameRange& range, const char* field) {
  TVL_CHECK_INPUT(range.begin >= 0 && range.end >= range.begin)
      << field << ": want 0 <= A <= B, is " << range.begin << ":" << range.end;
}

// Sets one option from its text.
void SetOption(const std::string& key, const std::string& value, SimOptions* o) {
  const std::map<std::string, std::function<void()>> setters = {
      {"seed", [&] { o->seed = ParseNumber<uint64_t>(value, key); }},
      {"frames", [&] { o->frames = ParseNumber<int>(value, key); }},
      {"raw", [&] { o->raw = ParseSpin(value); }},
      {"clean", [&] { o->clean = ParseFlag(value, key); }},
      {"camera", [&] { o->has_camera = ParseFlag(value, key); }},
      {"rings", [&] { o->exact_rings = ParseFlag(value, key); }},
      {"threads", [&] { o->threads = ParseNumber<int>(value, key); }},
      {"trajectory", [&] { o->trajectory_file = value; }},
      {"changes", [&] { o->changes = ParseNumber<double>(value, key); }},
      {"lateral", [&] { o->lateral_m = ParseNumber<double>(value, key); }},
      {"tunnel", [&] { o->tunnel = ParseFrameRange(value, key); }},
      {"open", [&] { o->open = ParseFrameRange(value, key); }},
      {"night", [&] { o->night = ParseFrameRange(value, key); }},
  };
  const auto setter = setters.find(key);
  if (setter == setters.end()) {
    std::string known;
    for (const auto& [name, unused] : setters) known += " " + name;
    TVL_CHECK_INPUT(false) << "unknown key '" << key << "' in a sim: input; known:" << known;
  }
  setter->second();
}

}  // namespace

FrameRange ParseFrameRange(const std::string& text, const std::string& field) {
  const size_t colon = text.find(':');
  TVL_CHECK_INPUT(colon != std::string::npos) << field << ": want A:B, got '" << text << "'";
  const FrameRange range{ParseNumber<int>(text.substr(0, colon), field),
                         ParseNumber<int>(text.substr(colon + 1), field)};
  TVL_CHECK_INPUT(range.begin >= 0 && range.begin < range.end)
      << field << ": want A:B with 0 <= A < B, got '" << text << "'";
  return range;
}

void SimOptions::Check() const {
  const bool is_known = std::any_of(kPresets.begin(), kPresets.end(),
                                    [&](const char* name) { return preset == name; });
  TVL_CHECK_INPUT(is_known) << "preset: unknown '" << preset
                            << "'; known: city loop reverse traffic aliasing nightloop lateloop "
                               "tunnel open";
  TVL_CHECK_INPUT(frames >= (trajectory_file.empty() ? 1 : 0))
      << "frames: must be positive, is " << frames;
  TVL_CHECK_INPUT(threads >= 1) << "threads: must be at least 1, is " << threads;
  TVL_CHECK_INPUT(changes >= 0.0 && changes <= 1.0) << "changes: want 0..1, is " << changes;
  TVL_CHECK_INPUT(lateral_m >= 0.0 && lateral_m <= 2.5)
      << "lateral: want 0..2.5 m, is " << lateral_m;
  TVL_CHECK_INPUT(lateral_m == 0.0 || (IsLoopPreset(preset) && trajectory_file.empty()))
      << "lateral: only for loop, nightloop and lateloop on their own routes";
  CheckRange(tunnel, "tunnel");
  CheckRange(open, "open");
  CheckRange(night, "night");
}

bool IsLoopPreset(const std::string& preset) {
  return preset == "loop" || preset == "nightloop" || preset == "lateloop";
}

bool IsSimUri(const std::string& text) { return text.rfind(kPrefix, 0) == 0; }

Deskew ParseSpin(const std::string& text) {
  if (text == "none") return Deskew::kNone;
  if (text == "cw") return Deskew::kClockwise;
  if (text == "ccw") return Deskew::kCounterClockwise;
  TVL_CHECK_INPUT(false) << "raw: want none, cw or ccw, got '" << text << "'";
  return Deskew::kNone;
}

SimOptions ParseSimUri(const std::string& uri) {
  TVL_CHECK_INPUT(IsSimUri(uri)) << "not a sim: input: " << uri;
  const std::string body = uri.substr(std::string(kPrefix).size());
  const size_t mark = body.find('?');
  SimOptions options;
  options.preset = body.substr(0, mark);
  std::istringstream pairs(mark == std::string::npos ? "" : body.substr(mark + 1));
  for (std::string pair; std::getline(pairs, pair, '&');) {
    const size_t equals = pair.find('=');
    TVL_CHECK_INPUT(equals != std::string::npos)
        << "want key=value in '" << uri << "', got '" << pair << "'";
    SetOption(pair.substr(0, equals), pair.substr(equals + 1), &options);
  }
  options.Check();
  return options;
}

}  // namespace tvl::sim
