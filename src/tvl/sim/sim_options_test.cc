#include "tvl/sim/sim_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/sim/sensors.h"

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

TEST(SimUriTest, SpeedAndSensorsCanBeChosen) {
  const SimOptions o = ParseSimUri("sim:traffic?speed=15&turn=1&beams=32&faults=late:3,0.1;equal");
  EXPECT_EQ(o.speed_m_s, 15.0);
  EXPECT_TRUE(o.is_turning);
  EXPECT_EQ(o.beams, 32);
  EXPECT_TRUE(o.HasRings());
  EXPECT_EQ(o.faults, "late:3,0.1;equal");
  EXPECT_FALSE(ParseSimUri("sim:city").HasRings());
  EXPECT_THAT(ErrorOf("sim:city?beams=48"), HasSubstr("beams: want 16, 32 or 64"));
  EXPECT_THAT(ErrorOf("sim:city?speed=60"), HasSubstr("speed: want 1..40"));
  EXPECT_THAT(ErrorOf("sim:loop?speed=10"), HasSubstr("speed: only for city"));
  EXPECT_THAT(ErrorOf("sim:city?speed=10&trajectory=a.txt"), HasSubstr("speed: only for city"));
  EXPECT_THAT(ErrorOf("sim:city?turn=1"), HasSubstr("turn: needs a speed"));
  EXPECT_THAT(ErrorOf("sim:city?faults=lose:3"), HasSubstr("fault 'lose:3': unknown"));
}

TEST(SimUriTest, ErrorsOfBeamsHaveASizeAndAShape) {
  const SimOptions o = ParseSimUri("sim:city?beam_errors=3&beam_error_shape=sine");
  EXPECT_EQ(o.beam_errors, 3.0);
  EXPECT_EQ(o.beam_error_shape, BeamErrorShape::kSine);
  const LidarSensorOptions usual = LidarErrorsFor(ParseSimUri("sim:city")),
                           lidar = LidarErrorsFor(o);
  EXPECT_EQ(usual.beam_error_shape, BeamErrorShape::kIndependent);
  EXPECT_EQ(lidar.beam_error_shape, BeamErrorShape::kSine);
  EXPECT_DOUBLE_EQ(lidar.beam_elevation_sigma_rad, 3.0 * usual.beam_elevation_sigma_rad);
  EXPECT_DOUBLE_EQ(lidar.beam_range_sigma_m, 3.0 * usual.beam_range_sigma_m);
  EXPECT_EQ(lidar.range_sigma_m, usual.range_sigma_m) << "noise stays";
  EXPECT_THAT(ErrorOf("sim:city?beam_errors=-1"), HasSubstr("beam_errors: want 0..10"));
  EXPECT_THAT(ErrorOf("sim:city?beam_error_shape=square"), HasSubstr("beam_error_shape: want"));
}

TEST(SimUriTest, HighwayAndTunnelHaveKeysOfTheirOwn) {
  EXPECT_EQ(ParseSimUri("sim:highway").frames, 600) << "1500 m at 25 m/s";
  EXPECT_EQ(ParseSimUri("sim:highway?speed=35").frames, 429);
  EXPECT_EQ(ParseSimUri("sim:highway?frames=20").frames, 20);
  EXPECT_EQ(ParseSimUri("sim:highway?road=wet").road, RoadSurface::kWet);
  EXPECT_EQ(ParseSimUri("sim:tunnel?faster=0.4").faster, 0.4);
  EXPECT_THAT(ErrorOf("sim:highway?road=dry"), HasSubstr("road: want rich, poor or wet"));
  EXPECT_THAT(ErrorOf("sim:city?road=wet"), HasSubstr("road: only for highway"));
  EXPECT_THAT(ErrorOf("sim:city?faster=0.4"), HasSubstr("faster: only for tunnel"));
  EXPECT_THAT(ErrorOf("sim:tunnel?faster=2"), HasSubstr("faster: want 0..1"));
  EXPECT_THAT(ErrorOf("sim:jam?tunnel=5:9"), HasSubstr("not for jam"));
}

TEST(SimUriTest, ImagesCanBeLate) {
  EXPECT_EQ(ParseSimUri("sim:city?delay=-20.5").camera_delay_ms, -20.5);
  EXPECT_EQ(ParseSimUri("sim:city").camera_delay_ms, 0.0);
  EXPECT_THAT(ErrorOf("sim:city?delay=200"), HasSubstr("delay: want -100..100 ms"));
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
