#include "tvl/cli/input.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

TEST(OpenInput, NamesWhatIsWrong) {
  try {
    OpenInput("no/such/folder");
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_EQ(std::string(e.what()), "no/such/folder: no such folder");
  }
  try {
    const TempFolder empty;
    OpenInput(empty.path().string());
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(": no recording that tvl knows"), std::string::npos);
  }
  EXPECT_THROW(OpenInput("sim:no such preset"), InputError);
  InputOptions options;
  options.profile = "no such profile";
  EXPECT_THROW(OpenInput(".", options), InputError);
  options.rig = "rig.yaml";
  EXPECT_THROW(OpenInput(".", options), InputError);  // both
}

#ifdef TVL_WITH_SIM
TEST(OpenInput, OpensSimulatedDrivesWithTheirProfileOrAnother) {
  const std::string spec = "sim:open?frames=2&camera=0&seed=3";
  const auto own = OpenInput(spec);
  EXPECT_EQ(own->size(), 2U);
  EXPECT_EQ(own->setup().lidar.rows(), 64);
  InputOptions options;
  options.profile = "none";
  const auto other = OpenInput(spec, options);
  EXPECT_EQ(other->setup().lidar.rows(), 0);
  EXPECT_EQ(other->Frame(1).scan->points, own->Frame(1).scan->points);
  EXPECT_EQ(other->Truth_T_first_cam0().size(), 2U);
}
#endif

}  // namespace
}  // namespace tvl
