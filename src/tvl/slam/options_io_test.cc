#include "tvl/slam/options_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <set>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/base/units.h"
#include "tvl/slam/option_value.h"
#include "tvl/slam/options_fields.h"

namespace tvl {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

RunOptions FromYaml(const std::string& yaml) { return ApplyYaml(yaml, "test.yaml", {}); }

// The message of the InputError that a text gives; empty if it is accepted.
std::string Complaint(const std::string& yaml) {
  try {
    FromYaml(yaml);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

// --- Every field of every struct is visited.

struct AnyValue {
  template <typename T>
  operator T() const;  // NOLINT: never called, only converted to whatever a field is
};

template <typename T, size_t... I>
auto TakesFields(std::index_sequence<I...>) -> decltype(T{(void(I), AnyValue{})...}, true);
template <typename T, size_t N, typename = void>
struct Takes : std::false_type {};
template <typename T, size_t N>
struct Takes<T, N, std::void_t<decltype(TakesFields<T>(std::make_index_sequence<N>{}))>>
    : std::true_type {};

// Fields of an aggregate: as many as it can be initialised with.
template <typename T, size_t N = 0>
constexpr size_t FieldCount() {
  if constexpr (Takes<T, N + 1>::value) {
    return FieldCount<T, N + 1>();
  } else {
    return N;
  }
}

struct CountedExample {
  double a = 1.0, b = 2.0;
  SurfelMapOptions nested;
  std::vector<double> list;
  void Check() const;
};
static_assert(FieldCount<CountedExample>() == 4);

// Compares the fields of each section with those visited, and sees that none comes twice.
class CompletenessVisitor {
 public:
  explicit CompletenessVisitor(std::string path) : path_(std::move(path)) {}
  template <typename T>
  void operator()(const char* name, T& field) {
    EXPECT_TRUE(addresses_.insert(&field).second) << path_ << name << " is visited twice";
    if constexpr (kIsSection<T>) {
      CompletenessVisitor inner(path_ + name + ".");
      VisitFields(inner, field);
      EXPECT_EQ(inner.addresses_.size(), FieldCount<T>())
          << path_ << name << ": add its new field to options_fields.h and docs/options.md";
    }
  }
  size_t count() const { return addresses_.size(); }

 private:
  std::string path_;
  std::set<const void*> addresses_;
};

TEST(OptionsIo, EveryFieldIsVisited) {
  SlamOptions options;
  CompletenessVisitor visitor("");
  VisitFields(visitor, options);
  EXPECT_EQ(visitor.count(), FieldCount<SlamOptions>());
}

TEST(OptionsIo, AllOfARunButItsThreadsIsVisited) {
  RunOptions options;
  CompletenessVisitor visitor("");
  VisitFields(visitor, options);
  // The fields of RunOptions::slam lie at the top level.
  EXPECT_EQ(visitor.count() - FieldCount<SlamOptions>() + 2, FieldCount<RunOptions>());
}

// --- Loading.

TEST(OptionsIo, OverridesNestedKeys) {
  const RunOptions options = FromYaml(
      "use_camera: false\n"
      "mapping:\n"
      "  interval: 5\n"
      "  local_map:\n"
      "    lines: {sizes_m: [0.8, 1.6], kind: line}\n"
      "preprocessing:\n"
      "  depth: {max_depth_m: 40, use_outlier_points: yes}\n");
  EXPECT_EQ(options.slam.mapping.interval, 5);
  EXPECT_FALSE(options.slam.use_camera);
  EXPECT_EQ(options.slam.mapping.local_map.lines.sizes_m, (std::vector<double>{0.8, 1.6}));
  EXPECT_EQ(options.slam.preprocessing.depth.max_depth_m, 40.0);
  EXPECT_TRUE(options.slam.preprocessing.depth.use_outlier_points);
  // The rest keeps its defaults, also where they differ from those of the type.
  const RunOptions defaults;
  EXPECT_EQ(options.slam.mapping.local_map.lines.surfel.min_points,
            defaults.slam.mapping.local_map.lines.surfel.min_points);
  EXPECT_EQ(options.slam.odometry.first_gate_m, defaults.slam.odometry.first_gate_m);
}

TEST(OptionsIo, OverridesDottedKeys) {
  EXPECT_EQ(FromYaml("mapping.interval: 5").slam.mapping.interval, 5);
  const RunOptions mixed = FromYaml(
      "mapping:\n"
      "  scan_to_map.weakness.held_rotation: 7\n"
      "mapping.keyframes: {min_translation_m: 2.5}\n");
  EXPECT_EQ(mixed.slam.mapping.scan_to_map.weakness.held_rotation, 7.0);
  EXPECT_EQ(mixed.slam.mapping.keyframes.min_translation_m, 2.5);
}

TEST(OptionsIo, KeepsWhatTheBaseSays) {
  RunOptions base;
  base.threads = 3;
  base.slam.mapping.interval = 4;
  base.slam.use_camera = false;
  const RunOptions options = ApplyYaml("use_camera: true", "test.yaml", base);
  EXPECT_EQ(options.threads, 3);
  EXPECT_EQ(options.slam.mapping.interval, 4);
  EXPECT_TRUE(options.slam.use_camera);
}

TEST(OptionsIo, AnglesAreDegrees) {
  const RunOptions options = FromYaml(
      "preprocessing.depth.min_incidence_deg: 10\n"
      "odometry.covariance.floor_rotation_deg_per_m: 0.003\n"
      "preprocessing.depth.min_triangle_area_rad_sq: 1.0e-5\n");
  EXPECT_DOUBLE_EQ(options.slam.preprocessing.depth.min_incidence_rad, DegToRad(10.0));
  EXPECT_DOUBLE_EQ(options.slam.odometry.covariance.floor_rotation_rad_per_m, DegToRad(0.003));
  EXPECT_EQ(options.slam.preprocessing.depth.min_triangle_area_rad_sq, 1e-5);
  EXPECT_THAT(Complaint("preprocessing.depth.min_incidence_rad: 0.1"),
              HasSubstr("did you mean `preprocessing.depth.min_incidence_deg`?"));
}

TEST(OptionsIo, DeskewIsAWord) {
  EXPECT_EQ(FromYaml("deskew: cw").deskew, Deskew::kClockwise);
  EXPECT_EQ(FromYaml("deskew: auto").deskew, std::nullopt);
  EXPECT_EQ(FromYaml("deskew_decision: {max_frames: 12}").decision.max_frames, 12);
  EXPECT_THAT(Complaint("\n\ndeskew: left"),
              AllOf(StartsWith("test.yaml:3: deskew: "), HasSubstr("auto, none, cw, ccw"),
                    HasSubstr("`left`")));
}

TEST(OptionsIo, EmptyTextsAndSectionsChangeNothing) {
  const std::string defaults = DumpOptions({});
  EXPECT_EQ(DumpOptions(FromYaml("")), defaults);
  EXPECT_EQ(DumpOptions(FromYaml("# only a comment\n")), defaults);
  EXPECT_EQ(DumpOptions(FromYaml("mapping:\n  # interval: 5\nodometry: {}\n")), defaults);
}

// --- Refusals name source, line and key.

TEST(OptionsIo, UnknownKeysAreErrorsWithASuggestion) {
  EXPECT_THAT(Complaint("mapping:\n  intervall: 5\n"),
              AllOf(StartsWith("test.yaml:2: mapping.intervall: unknown key"),
                    HasSubstr("did you mean `mapping.interval`?")));
  EXPECT_THAT(Complaint("interval: 5"), HasSubstr("did you mean `mapping.interval`?"));
  EXPECT_THAT(Complaint("odometri:\n  covariance:\n    inflation: 5\n"),
              AllOf(StartsWith("test.yaml:3: "),
                    HasSubstr("did you mean `odometry.covariance.inflation`?")));
  EXPECT_THAT(Complaint("bananas: 5"),
              AllOf(HasSubstr("bananas: unknown key"), Not(HasSubstr("did you mean"))));
  EXPECT_THAT(Complaint("threads: 2"), HasSubstr("unknown key"));
  EXPECT_THAT(Complaint("mapping.interval: {every: 5}"), HasSubstr("unknown key"));
}

TEST(OptionsIo, RepeatedKeysAreErrors) {
  EXPECT_THAT(Complaint("mapping.interval: 5\nmapping:\n  interval: 2\n"),
              AllOf(StartsWith("test.yaml:3: mapping.interval: given twice"), HasSubstr("line 1")));
}

TEST(OptionsIo, WrongKindsNameTheField) {
  EXPECT_THAT(Complaint("mapping:\n  interval: often"),
              AllOf(StartsWith("test.yaml:2: mapping.interval: "), HasSubstr("whole number"),
                    HasSubstr("`often`")));
  EXPECT_THAT(Complaint("mapping.interval: 2.5"), HasSubstr("whole number"));
  EXPECT_THAT(Complaint("mapping.interval: 99999999999"), HasSubstr("whole number"));
  EXPECT_THAT(Complaint("mapping.interval: [5]"), HasSubstr("is a list"));
  EXPECT_THAT(Complaint("mapping.interval:"), HasSubstr("has no value"));
  EXPECT_THAT(Complaint("use_camera: 3"), HasSubstr("true or false"));
  EXPECT_THAT(Complaint("odometry.first_gate_m: 1.5 m"), HasSubstr("want a number"));
  EXPECT_THAT(Complaint("odometry.first_gate_m: .nan"), HasSubstr("finite"));
  EXPECT_THAT(Complaint("odometry.first_gate_m: .inf"), HasSubstr("finite"));
  EXPECT_THAT(Complaint("mapping.local_map.planes.sizes_m: 1.0"), HasSubstr("want a list"));
  EXPECT_THAT(Complaint("mapping.local_map.planes.sizes_m: [1.0, x]"), HasSubstr("sizes_m"));
  EXPECT_THAT(Complaint("mapping.local_map.planes.kind: dot"), HasSubstr("plane, line"));
  EXPECT_THAT(Complaint("mapping: 5"), HasSubstr("test.yaml:1: mapping: is a section"));
}

TEST(OptionsIo, WhatIsNoMapIsRefused) {
  EXPECT_THAT(Complaint("mapping: [1, 2\nodometry: 3"), StartsWith("test.yaml:"));
  EXPECT_THAT(Complaint("- a\n- b\n"), HasSubstr("`key: value`"));
  EXPECT_THAT(Complaint("[a, b]: 5"), HasSubstr("a key is a word"));
  EXPECT_THAT(Complaint("use_camera: true\n---\nuse_camera: false\n"), HasSubstr("more than one"));
  EXPECT_THAT(Complaint("mapping: &m\n  again: *m\n"), HasSubstr("nests too deeply"));
}

TEST(OptionsIo, BadValuesNameLineAndSection) {
  EXPECT_THAT(Complaint("odometry:\n  max_refreshes: 0\n"),
              AllOf(StartsWith("test.yaml:2: odometry: "), HasSubstr("max_refreshes")));
  EXPECT_THAT(Complaint("# angles are found by either name\n"
                        "preprocessing.depth.min_incidence_deg: 91\n"),
              AllOf(StartsWith("test.yaml:2: preprocessing.depth: "), HasSubstr("min_incidence")));
  EXPECT_THAT(Complaint("mapping.interval: 0"), StartsWith("test.yaml:1: mapping.interval"));
  EXPECT_THAT(Complaint("deskew_decision.max_frames: 1"),
              StartsWith("test.yaml:1: deskew_decision: "));
}

TEST(OptionsIo, UnreadableFilesAreNamed) {
  for (const std::string path : {"no/such/file.yaml", TVL_SOURCE_DIR "/config"}) {
    try {
      LoadOptions(path);
      ADD_FAILURE() << path << " was read";
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), StartsWith(path));
    }
  }
}

// --- Dumping.

// Gives every value one that differs from its default, so that a round trip which keeps defaults
// is seen through.
class Scrambler {
 public:
  template <typename T>
  void operator()(const char*, T& field) {
    if constexpr (kIsSection<T>) {
      VisitFields(*this, field);
    } else if constexpr (std::is_same_v<T, bool>) {
      field = !field;
    } else if constexpr (std::is_same_v<T, int>) {
      field += 2;
    } else if constexpr (std::is_same_v<T, double>) {
      field *= 1.0 + 1.0 / 3.0e4;
    } else if constexpr (std::is_same_v<T, std::vector<double>>) {
      field.push_back(4.0 + 1.0 / 3.0);
    } else if constexpr (std::is_same_v<T, std::string>) {
      field += "a folder: #1";
    } else if constexpr (std::is_same_v<T, LoopLoss>) {
      field = field == LoopLoss::kHuber ? LoopLoss::kNone : LoopLoss::kHuber;
    } else if constexpr (std::is_same_v<T, SurfelKind>) {
      field = field == SurfelKind::kPlane ? SurfelKind::kLine : SurfelKind::kPlane;
    } else {
      field = Deskew::kCounterClockwise;
    }
  }
};

// All values as doubles (lists and words: a hash of their text), in order.
class Flattener {
 public:
  template <typename T>
  void operator()(const char* name, T& field) {
    if constexpr (kIsSection<T>) {
      VisitFields(*this, field);
    } else if constexpr (std::is_arithmetic_v<T>) {
      values.push_back(static_cast<double>(field));
    } else {
      const size_t hash = std::hash<std::string>()(ValueText(field, IsAngleField(name)));
      values.push_back(static_cast<double>(hash));
    }
  }
  std::vector<double> values;
};

std::vector<double> Values(RunOptions options) {
  Flattener flattener;
  VisitFields(flattener, options);
  return flattener.values;
}

TEST(OptionsIo, RoundTripKeepsEveryValue) {
  RunOptions defaults;
  RunOptions other;
  Scrambler scrambler;
  VisitFields(scrambler, other);
  for (const RunOptions& options : {defaults, other}) {
    const std::vector<double> want = Values(options);
    const std::vector<double> got = Values(FromYaml(DumpOptions(options)));
    ASSERT_EQ(want.size(), OptionKeys().size());
    ASSERT_EQ(got.size(), want.size());
    for (size_t i = 0; i < want.size(); ++i) {
      EXPECT_EQ(got[i], want[i]) << OptionKeys()[i];
    }
  }
  EXPECT_NE(Values(defaults), Values(other));
}

TEST(OptionsIo, ScramblingChangesEveryValue) {
  RunOptions other;
  Scrambler scrambler;
  VisitFields(scrambler, other);
  const std::vector<double> before = Values({});
  const std::vector<double> after = Values(other);
  for (size_t i = 0; i < before.size(); ++i) {
    EXPECT_TRUE(before[i] != after[i] || before[i] == 0.0) << OptionKeys()[i];
  }
}

TEST(OptionsIo, DumpIsShortAndTyped) {
  const std::string dump = DumpOptions({});
  EXPECT_THAT(dump, HasSubstr("\nmapping:\n  interval: 1\n"));
  EXPECT_THAT(dump, HasSubstr("    min_incidence_deg: 3.5\n"));
  EXPECT_THAT(dump, HasSubstr("sizes_m: [0.5, 1.0, 2.0]\n"));
  EXPECT_THAT(dump, HasSubstr("use_camera: true\n"));
  EXPECT_THAT(dump, StartsWith("deskew: auto\n"));
}

TEST(OptionsIo, NumbersAreWrittenForAllReaders) {
  EXPECT_EQ(NumberText(100.0, false), "100.0");
  EXPECT_EQ(NumberText(0.1, false), "0.1");
  EXPECT_EQ(NumberText(1e-6, false), "1.0e-06");
  EXPECT_EQ(NumberText(8e-6, false), "8.0e-06");
  EXPECT_EQ(NumberText(1.0 / 3.0, false), "0.3333333333333333");
  EXPECT_EQ(NumberText(-2.5e20, false), "-2.5e+20");
  EXPECT_EQ(NumberText(DegToRad(0.205), true), "0.205");
}

TEST(OptionsIo, AnglesComeBackToTheBit) {
  Rng rng(7);
  for (int i = 0; i < 2000; ++i) {
    const double angle_rad = rng.Uniform(-4.0, 4.0) * std::pow(0.1, rng.Uniform(0.0, 7.0));
    const std::string text = NumberText(angle_rad, true);
    EXPECT_EQ(NumberFromNode(YAML::Load(text), true, "angle"), angle_rad) << text;
  }
}

}  // namespace
}  // namespace tvl
