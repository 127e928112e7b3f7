#include "tvl/io/cloud/file_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tvl/io/temp_folder.h"

namespace tvl {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(FileNames, NaturalOrderComparesNumbers) {
  std::vector<std::string> names = {"10.pcd",
                                    "2.pcd",
                                    "a2b10",
                                    "a2b9",
                                    "007",
                                    "7",
                                    "a",
                                    "1.pcd",
                                    "99999999999999999999",
                                    "100000000000000000000"};
  std::sort(names.begin(), names.end(), NaturalLess);
  EXPECT_THAT(names, ElementsAre("1.pcd", "2.pcd", "007", "7", "10.pcd", "99999999999999999999",
                                 "100000000000000000000", "a", "a2b9", "a2b10"));
  for (const std::string& a : names) {
    EXPECT_FALSE(NaturalLess(a, a));
    for (const std::string& b : names) EXPECT_EQ(NaturalLess(a, b) || NaturalLess(b, a), a != b);
  }
}

TEST(FileNames, ListsFilesOfTheseExtensions) {
  const TempFolder folder;
  for (const char* name : {"10.PCD", "9.pcd", ".8.pcd", "7.txt", "6.pcd/a.pcd"}) {
    folder.Write(name, "");
  }
  EXPECT_THAT(ListFiles(folder.path(), {".pcd"}), ElementsAre(folder / "9.pcd", folder / "10.PCD"));
  EXPECT_THAT(ListFiles(folder / "none", {".pcd"}), IsEmpty());
}

TEST(FileNames, FindsNumbers) {
  const auto text = [](const std::string& path) {
    const auto number = NumberOf(path);
    return number ? number->prefix + "|" + number->text : std::string("none");
  };
  EXPECT_EQ(text("a/000017.bin"), "|000017");
  EXPECT_EQ(text("1317376000.123456.pcd"), "|1317376000.123456");
  EXPECT_EQ(text("LIDAR_TOP__1532402927647951.pcd.bin"), "LIDAR_TOP__|1532402927647951");
  EXPECT_EQ(text("scan_1317376000_123456789.ply"), "scan_|1317376000.123456789");
  EXPECT_EQ(text("scan_12_13.ply"), "scan_12_|13");
  EXPECT_EQ(text("v1.2.3.las"), "v1.|2.3");
  EXPECT_EQ(text("cloud.las"), "none");
  EXPECT_EQ(text("17a.las"), "none");
  EXPECT_EQ(text("..las"), "none");
  EXPECT_EQ(FrameNumberOf("000017.bin"), 17);
  EXPECT_EQ(FrameNumberOf("1.5.bin"), std::nullopt);
  EXPECT_EQ(FrameNumberOf(std::string(30, '9') + ".bin"), std::nullopt);
}

TEST(FileNames, PairsByNameAndNumber) {
  EXPECT_THAT(PairByName({"s/a.pcd", "s/000007.bin", "s/9.bin"}, {"i/a.png", "i/frame_7.jpg"}),
              ElementsAre("i/a.png", "i/frame_7.jpg", ""));
}

TEST(FileNames, NamesFolders) {
  EXPECT_EQ(NameOfFolder("a/b/"), "b");
  EXPECT_EQ(NameOfFolder("a/b"), "b");
  EXPECT_EQ(NameOfFolder("a/b/../c/."), "c");
}

}  // namespace
}  // namespace tvl
