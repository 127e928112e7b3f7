#include "tvl/cli/output_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string ErrorOf(const std::string& folder) {
  try {
    PrepareOutputFolder(folder);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(OutputFolder, IsMadeAndLeftEmpty) {
  const TempFolder folder;
  EXPECT_EQ(ErrorOf(folder / "a/b"), "");
  EXPECT_EQ(ErrorOf(folder / "a/b/"), "");
  EXPECT_TRUE(fs::is_empty(folder.path() / "a/b"));
}

TEST(OutputFolder, ThatCannotBeWrittenIsRefusedByName) {
  const TempFolder folder;
  folder.Write("file", "x");
  EXPECT_THAT(ErrorOf(folder / "file"), HasSubstr("file: cannot be made"));
  EXPECT_THAT(ErrorOf(folder / "file/out"), HasSubstr("file/out: cannot be made"));
  EXPECT_THAT(ErrorOf("/proc"), HasSubstr("/proc: cannot be written to"));
  fs::create_directories(folder.path() / "out/run.json");
  EXPECT_THAT(ErrorOf(folder / "out"), HasSubstr("run.json: a folder is in the way"));
}

TEST(OutputFolder, LosesTheResultsOfAnEarlierRunAndNothingElse) {
  const TempFolder folder;
  for (const char* name : {"truth_kitti.txt", "map.ply", "loops.csv", "loop_place_7.png"}) {
    folder.Write(name, "old");
  }
  const std::vector<std::string> others = {"notes.txt", "loop_place_of_mine.png", "map.pcd.bak",
                                           "plots/map.ply"};
  for (const std::string& name : others) folder.Write(name, "mine");
  RemoveOldResults(folder.path().string());
  for (const std::string& name : others) EXPECT_TRUE(fs::exists(folder / name)) << name;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 4);
}

}  // namespace
}  // namespace tvl
