#include "tvl/sim/sim_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl::sim {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const std::string& uri) {
  try {
    ParseSimUri(uri);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(SimUriTest, SetsEveryOption) {
  const SimOptions o = ParseSimUri(
      "sim:loop?seed=7&frames=1000&raw=ccw&clean=1&trajectory=poses.txt&tunnel=5:10&open=20:30"
      "&night=1:2&camera=0&rings=1&threads=2");
  EXPECT_EQ(o.preset, "loop");
  EXPECT_EQ(o.seed, 7U);
  EXPECT_EQ(o.frames, 1000);
  EXPECT_EQ(o.raw, Deskew::kCounterClockwise);
  EXPECT_TRUE(o.clean);
  EXPECT_EQ(o.trajectory_file, "poses.txt");
  EXPECT_TRUE(o.tunnel.Contains(5) && !o.tunnel.Contains(10));
  EXPECT_TRUE(o.open.Contains(29));
  EXPECT_TRUE(o.night.Contains(1));
  EXPECT_FALSE(o.has_camera);
  EXPECT_TRUE(o.exact_rings);
  EXPECT_EQ(o.threads, 2);
}

TEST(SimUriTest, DefaultsToErrorsAndCamera) {
  const SimOptions o = ParseSimUri("sim:city");
  EXPECT_FALSE(o.clean);
  EXPECT_TRUE(o.has_camera);
  EXPECT_EQ(o.raw, Deskew::kNone);
}

TEST(SimUriTest, PlacesMayChangeBetweenPasses) {
  const SimOptions o = ParseSimUri("sim:lateloop?changes=0.5&lateral=2");
  EXPECT_EQ(o.changes, 0.5);
  EXPECT_EQ(o.lateral_m, 2.0);
  EXPECT_EQ(ParseSimUri("sim:loop").changes, 0.0);
  EXPECT_EQ(ParseSimUri("sim:loop").lateral_m, 0.0);
  EXPECT_THAT(ErrorOf("sim:city?changes=1.5"), HasSubstr("changes: want 0..1"));
  EXPECT_THAT(ErrorOf("sim:city?changes=nan"), HasSubstr("changes: want 0..1"));
  EXPECT_THAT(ErrorOf("sim:city?changes=half"), HasSubstr("changes: want a number"));
  EXPECT_THAT(ErrorOf("sim:loop?lateral=3"), HasSubstr("lateral: want 0..2.5"));
  EXPECT_THAT(ErrorOf("sim:reverse?lateral=1"), HasSubstr("lateral: only for loop"));
  EXPECT_THAT(ErrorOf("sim:loop?lateral=1&trajectory=a.txt"), HasSubstr("lateral: only for loop"));
}

TEST(SimUriTest, NamesWhatIsWrong) {
  EXPECT_THAT(ErrorOf("sim:city?sed=7"), HasSubstr("unknown key 'sed'"));
  EXPECT_THAT(ErrorOf("sim:village"), HasSubstr("preset: unknown 'village'"));
  EXPECT_THAT(ErrorOf("sim:city?seed=x"), HasSubstr("seed: want a whole number"));
  EXPECT_THAT(ErrorOf("sim:city?seed=7.5"), HasSubstr("seed"));
  EXPECT_THAT(ErrorOf("sim:city?frames=0"), HasSubstr("frames: must be positive"));
  EXPECT_THAT(ErrorOf("sim:city?frames"), HasSubstr("key=value"));
  EXPECT_THAT(ErrorOf("sim:city?raw=left"), HasSubstr("raw: want none, cw or ccw"));
  EXPECT_THAT(ErrorOf("sim:city?tunnel=9:3"), HasSubstr("tunnel: want A:B"));
  EXPECT_THAT(ErrorOf("sim:city?night=3"), HasSubstr("night: want A:B"));
  EXPECT_THAT(ErrorOf("sim:city?clean=yes"), HasSubstr("clean: want 0 or 1"));
  EXPECT_THAT(ErrorOf("city"), HasSubstr("not a sim: input"));
}

TEST(SimUriTest, IsRecognisedByItsPrefix) {
  EXPECT_TRUE(IsSimUri("sim:city"));
  EXPECT_FALSE(IsSimUri("simulation/"));
}

}  // namespace
}  // namespace tvl::sim
