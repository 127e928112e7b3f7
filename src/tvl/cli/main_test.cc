// The program as a whole: exit codes, messages, files written. Runs the binary TVL_BINARY.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tvl/cli/test_program.h"
#include "tvl/io/profile.h"
#include "tvl/io/test_folder.h"
#include "tvl/io/text_file.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/vision/synthetic_texture.h"

namespace tvl {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(Program, HelpAndVersionSucceed) {
  const Outcome help = Run("--help");
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.out, HasSubstr("evaluate"));
  EXPECT_THAT(help.out, HasSubstr("inspect"));
  EXPECT_EQ(Run("--version").exit_code, 0);
  EXPECT_EQ(Run("inspect --help").exit_code, 0);
}

TEST_F(Program, WrongCommandLinesAreRefusedWithCode2) {
  EXPECT_EQ(Run("").exit_code, 2);
  EXPECT_EQ(Run("fly").exit_code, 2);
  EXPECT_EQ(Run("inspect").exit_code, 2);
  EXPECT_EQ(Run("inspect . --camera 9").exit_code, 2);
  EXPECT_EQ(Run("evaluate --truth a").exit_code, 2);
}

TEST_F(Program, InspectShowsAndJudges) {
  const TempFolder drive;
  WriteKittiFolder(drive, LoadProfile("kitti"), 3);
  const std::string root = drive.path().string();
  const Outcome good = Run("inspect " + root);
  EXPECT_EQ(good.exit_code, 0) << good.err;
  EXPECT_THAT(good.out, HasSubstr("frames     3"));
  EXPECT_THAT(good.out, HasSubstr("120x40, 8 bit, grey"));
  EXPECT_THAT(good.out, HasSubstr("faults     none"));
  std::filesystem::resize_file(drive / "velodyne/000001.bin", 1001);
  EXPECT_EQ(Run("inspect " + root).exit_code, 0);
  EXPECT_THAT(Run("inspect " + root).out, HasSubstr("truncated_scan: 1"));
  std::filesystem::resize_file(drive / "velodyne/000000.bin", 0);
  const Outcome bad = Run("inspect " + root);
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.out, HasSubstr("not usable: the first frame"));
  const Outcome missing = Run("inspect " + root + "/nix");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_THAT(missing.err, HasSubstr("nix: no such folder"));
}

TEST_F(Program, RunRefusesAnOutputFolderThatCannotBeWrittenBeforeTheFirstFrame) {
  WriteKittiFolder(folder_, LoadProfile("kitti"), 3);
  const std::string input = folder_.path().string();
  for (const std::string& out :
       {folder_ / "calib.txt", folder_ / "calib.txt/out", std::string("/proc")}) {
    const Outcome outcome = Run("run " + input + " --deskew none --out " + out);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(out + ": cannot be"));
    EXPECT_THAT(outcome.err, HasSubstr("--out"));
    EXPECT_THAT(outcome.err, Not(HasSubstr("frame")));
  }
}

TEST_F(Program, RunLeavesNothingOfAnEarlierRunAmongItsResults) {
  WriteKittiFolder(folder_, LoadProfile("kitti"), 3);
  const std::string run = "run " + folder_.path().string() + " --deskew none --out ";
  ASSERT_EQ(Run(run + (folder_ / "out")).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/truth_kitti.txt"));
  folder_.Write("out/loop_place_3.png", "old");
  folder_.Write("out/notes.txt", "mine");
  std::filesystem::remove(folder_ / "poses.txt");
  const Outcome again = Run(run + (folder_ / "out") + " --no-loops");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  for (const char* old : {"truth_kitti.txt", "loops.csv", "loops.png", "loop_place_3.png"}) {
    EXPECT_FALSE(std::filesystem::exists(folder_ / (std::string("out/") + old))) << old;
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/run.json"));
  EXPECT_EQ(Text(folder_ / "out/notes.txt"), "mine");
}

TEST_F(Program, RunShowsAndKeepsTheWarningsOfInspect) {
  WriteKittiFolder(folder_, LoadProfile("kitti"), 3);
  std::filesystem::remove_all(folder_ / "image_2");
  std::filesystem::remove(folder_ / "times.txt");
  std::filesystem::remove(folder_ / "velodyne/000001.bin");
  const std::string input = folder_.path().string(), out = folder_ / "out";
  const Outcome inspected = Run("inspect " + input);
  const Outcome run = Run("run " + input + " --deskew none --out " + out);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto warnings = nlohmann::json::parse(Text(out + "/run.json"))["warnings"];
  ASSERT_EQ(warnings.size(), 3U);
  for (const std::string warning : warnings) {
    EXPECT_THAT(inspected.out, HasSubstr("warning    " + warning + "\n"));
    EXPECT_THAT(run.err, HasSubstr("warning: " + warning + "\n"));
  }
}

TEST_F(Program, StampsSince1970AreKeptToTheNanosecond) {
  WriteKittiFolder(folder_, LoadProfile("kitti"), 2);
  folder_.Write("times.txt", "1317042145.964389445\n1.317042146064389447e+09\n");
  const std::string out = folder_ / "out";
  const Outcome run = Run("run " + folder_.path().string() + " --deskew none --out " + out);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::vector<std::string> lines = ReadLines(out + "/trajectory_tum.txt");
  EXPECT_THAT(lines.at(0), testing::StartsWith("1317042145.964389445 "));
  EXPECT_THAT(lines.at(1), testing::StartsWith("1317042146.064389447 "));
}

TEST_F(Program, VocabulariesAreTrainedShownAndCompared) {
  std::filesystem::create_directory(folder_ / "images");
  for (int i = 0; i < 4; ++i) {
    cv::imwrite(folder_ / ("images/" + std::to_string(i) + ".png"),
                MakeTexture({300, 150}, static_cast<uint64_t>(i / 2)));
  }
  const std::string images = folder_ / "images", file = folder_ / "voc.bin";
  const std::string train = "vocabulary train " + images + " --branching 8 --levels 3 --out ";
  const Outcome trained = Run(train + file);
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  EXPECT_THAT(trained.out, HasSubstr("trained on 4 images"));
  EXPECT_EQ(Run(train + (folder_ / "again.bin")).exit_code, 0);
  EXPECT_EQ(Text(file), Text(folder_ / "again.bin"));
  EXPECT_THAT(Run("vocabulary info " + file).out, HasSubstr("k 8, L 3"));
  EXPECT_THAT(Run("vocabulary info default").out, HasSubstr("k 10, L 4"));
  const Outcome compared = Run("vocabulary compare " + images + " --vocabulary " + file +
                               " --out " + (folder_ / "table.csv") + " --repeat 2");
  EXPECT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_THAT(compared.out, HasSubstr("at 8 images"));
  EXPECT_THAT(Text(folder_ / "table.csv"), HasSubstr("\n1,0,1\n"));
  EXPECT_EQ(Run("vocabulary info " + images).exit_code, 2);
  EXPECT_EQ(Run(train + "").exit_code, 2);
}

TEST_F(Program, EvaluateWritesTableJsonAndPlots) {
  std::vector<Rigid3d> truth, estimate;
  for (int i = 0; i < 150; ++i) {
    truth.push_back(Rigid3d::Translation(0, 0, i));
    estimate.push_back(Rigid3d::Translation(0, 0, 1.01 * i));
  }
  WriteKittiPoses(folder_ / "truth.txt", truth);
  WriteKittiPoses(folder_ / "run/trajectory_kitti.txt", estimate);
  const std::string arguments = "evaluate --truth " + (folder_ / "truth.txt") + " --estimate " +
                                (folder_ / "run/trajectory_kitti.txt");
  const Outcome outcome =
      Run(arguments + " --json " + (folder_ / "e.json") + " --plot " + (folder_ / "plots"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("run: 150 frames, 149.00 m"));
  EXPECT_THAT(outcome.out, HasSubstr("1.0100 %"));
  const auto json = nlohmann::json::parse(Text(folder_ / "e.json"));
  EXPECT_NEAR(json["kitti_segment_mean"]["t_err_percent"].get<double>(), 1.01, 1e-9);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "plots/run_top_view.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "plots/run_error.png"));
  // A longer estimate than truth cannot be paired; a later start can.
  EXPECT_EQ(Run(arguments + " --first 1").exit_code, 2);
  estimate.resize(140);
  WriteKittiPoses(folder_ / "run/trajectory_kitti.txt", estimate);
  const Outcome part = Run(arguments + " --first 10");
  EXPECT_EQ(part.exit_code, 0);
  EXPECT_THAT(part.err, HasSubstr("frames 10 to 149 of 150"));
}

}  // namespace
}  // namespace tvl
