#include "tvl/sim/sim_options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <sstream>
#include <type_traits>

#include "tvl/base/check.h"
#include "tvl/sensor/faulty_dataset.h"

namespace tvl::sim {
namespace {

constexpr std::array<const char*, 12> kPresets = {"city",     "loop",      "reverse",  "traffic",
                                                  "aliasing", "nightloop", "lateloop", "tunnel",
                                                  "open",     "jam",       "passing",  "highway"};
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

void CheckSpeed(const SimOptions& o) {
  TVL_CHECK_INPUT(o.speed_m_s == 0.0 || (o.speed_m_s >= 1.0 && o.speed_m_s <= 40.0))
      << "speed: want 1..40 m/s, is " << o.speed_m_s;
  TVL_CHECK_INPUT(o.speed_m_s == 0.0 || (HasSpeed(o.preset) && o.trajectory_file.empty()))
      << "speed: only for city, traffic, open and highway on their own routes";
  TVL_CHECK_INPUT(!o.is_turning || (o.speed_m_s > 0.0 && o.preset != "highway"))
      << "turn: needs a speed, and is not for highway, which has bends of its own";
  TVL_CHECK_INPUT(o.road == RoadSurface::kRich || o.preset == "highway")
      << "road: only for highway";
  TVL_CHECK_INPUT(o.faster >= 0.0 && o.faster <= 1.0) << "faster: want 0..1, is " << o.faster;
  TVL_CHECK_INPUT(o.faster == 0.0 || o.preset == "tunnel") << "faster: only for tunnel";
  const bool is_own_street = o.preset == "jam" || o.preset == "passing" || o.preset == "highway";
  TVL_CHECK_INPUT(!is_own_street || (o.trajectory_file.empty() && o.tunnel.IsEmpty()))
      << "trajectory, tunnel: not for " << o.preset << ", which has a street of its own";
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
      {"beams", [&] { o->beams = ParseNumber<int>(value, key); }},
      {"beam_errors", [&] { o->beam_errors = ParseNumber<double>(value, key); }},
      {"beam_error_shape", [&] { o->beam_error_shape = ParseBeamErrorShape(value); }},
      {"speed", [&] { o->speed_m_s = ParseNumber<double>(value, key); }},
      {"faults", [&] { o->faults = value; }},
      {"road", [&] { o->road = ParseRoad(value); }},
      {"faster", [&] { o->faster = ParseNumber<double>(value, key); }},
      {"delay", [&] { o->camera_delay_ms = ParseNumber<double>(value, key); }},
      {"turn", [&] { o->is_turning = ParseFlag(value, key); }},
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
                               "tunnel open jam passing highway";
  TVL_CHECK_INPUT(frames >= (trajectory_file.empty() ? 1 : 0))
      << "frames: must be positive, is " << frames;
  TVL_CHECK_INPUT(threads >= 1) << "threads: must be at least 1, is " << threads;
  TVL_CHECK_INPUT(changes >= 0.0 && changes <= 1.0) << "changes: want 0..1, is " << changes;
  TVL_CHECK_INPUT(lateral_m >= 0.0 && lateral_m <= 2.5)
      << "lateral: want 0..2.5 m, is " << lateral_m;
  TVL_CHECK_INPUT(lateral_m == 0.0 || (IsLoopPreset(preset) && trajectory_file.empty()))
      << "lateral: only for loop, nightloop and lateloop on their own routes";
  TVL_CHECK_INPUT(beams == 16 || beams == 32 || beams == 64)
      << "beams: want 16, 32 or 64, is " << beams;
  TVL_CHECK_INPUT(beam_errors >= 0.0 && beam_errors <= 10.0)
      << "beam_errors: want 0..10, is " << beam_errors;
  TVL_CHECK_INPUT(std::abs(camera_delay_ms) <= 100.0)
      << "delay: want -100..100 ms, is " << camera_delay_ms;
  CheckSpeed(*this);
  ParseFaults(faults);  // throws
  CheckRange(tunnel, "tunnel");
  CheckRange(open, "open");
  CheckRange(night, "night");
}

bool IsLoopPreset(const std::string& preset) {
  return preset == "loop" || preset == "nightloop" || preset == "lateloop";
}

bool HasSpeed(const std::string& preset) {
  return preset == "city" || preset == "traffic" || preset == "open" || preset == "highway";
}

int DefaultFrames(const SimOptions& options) {
  constexpr int kUsual = 300;
  if (options.preset != "highway") return kUsual;
  return static_cast<int>(std::ceil(10.0 * kHighway_m / HighwaySpeed_m_s(options)));
}

double HighwaySpeed_m_s(const SimOptions& options) {
  constexpr double kUsual_m_s = 25.0;  // 90 km/h
  return options.speed_m_s > 0.0 ? options.speed_m_s : kUsual_m_s;
}

RoadSurface ParseRoad(const std::string& text) {
  if (text == "rich") return RoadSurface::kRich;
  if (text == "poor") return RoadSurface::kPoor;
  TVL_CHECK_INPUT(text == "wet") << "road: want rich, poor or wet, got '" << text << "'";
  return RoadSurface::kWet;
}

BeamErrorShape ParseBeamErrorShape(const std::string& text) {
  if (text == "independent") return BeamErrorShape::kIndependent;
  TVL_CHECK_INPUT(text == "sine") << "beam_error_shape: want independent or sine, got '" << text
                                  << "'";
  return BeamErrorShape::kSine;
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
  bool has_frames = false;
  std::istringstream pairs(mark == std::string::npos ? "" : body.substr(mark + 1));
  for (std::string pair; std::getline(pairs, pair, '&');) {
    const size_t equals = pair.find('=');
    TVL_CHECK_INPUT(equals != std::string::npos)
        << "want key=value in '" << uri << "', got '" << pair << "'";
    SetOption(pair.substr(0, equals), pair.substr(equals + 1), &options);
    has_frames = has_frames || pair.substr(0, equals) == "frames";
  }
  if (!has_frames) options.frames = DefaultFrames(options);
  options.Check();
  return options;
}

}  // namespace tvl::sim
