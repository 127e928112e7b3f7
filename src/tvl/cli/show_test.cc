#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "tvl/base/check.h"
#include "tvl/cli/commands.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

void RunShow(std::vector<std::string> arguments) {
  CLI::App app;
  AddShowCommand(app);
  arguments.insert(arguments.begin(), "show");
  std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
  app.parse(arguments);
}

std::string ErrorOf(const std::vector<std::string>& arguments) {
  try {
    RunShow(arguments);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(Show, BadArgumentsAreNamed) {
  EXPECT_THAT(ErrorOf({"nowhere", "--frame", "0", "--stage", "map", "--out", "a.png"}),
              testing::HasSubstr("nowhere"));
  EXPECT_THAT(ErrorOf({"nowhere", "--frame", "0", "--stage", "map", "--out", "a.txt"}),
              testing::HasSubstr("--out a.txt"));
  EXPECT_THROW(RunShow({"nowhere", "--frame", "0", "--stage", "soup", "--out", "a.png"}),
               CLI::ValidationError);
}

TEST(Show, DrawsEveryStageOfRealData) {
  const char* data = std::getenv("TVL_TEST_DATA");
  if (!data) GTEST_SKIP() << "TVL_TEST_DATA is not set: real data not shown";
  const std::string input = std::string(data) + "/sequences/kitti_2011_09_26_0052";
  const fs::path folder = fs::path(testing::TempDir()) / "tvl_show_test";
  for (const std::string& stage :
       std::vector<std::string>{"tracks", "segments", "features", "depth", "map"}) {
    const std::string out = (folder / (stage + ".png")).string();
    RunShow({input, "--frame", "3", "--stage", stage, "--out", out});
    const cv::Mat picture = cv::imread(out);
    EXPECT_GT(picture.cols, 300) << stage;
    EXPECT_GT(picture.rows, 150) << stage;
  }
  EXPECT_THAT(ErrorOf({input, "--frame", "15", "--stage", "map", "--out", "a.png"}),
              testing::HasSubstr("--frame 15"));
  const std::string no_images = std::string(data) + "/sequences/kitti_odometry_00_first10";
  EXPECT_THAT(ErrorOf({no_images, "--frame", "1", "--stage", "tracks", "--out", "a.png"}),
              testing::HasSubstr("frame 1 has no usable image"));
  fs::remove_all(folder);
}

}  // namespace
}  // namespace tvl
