// tvl evaluate: trajectories against their truth, as a table, JSON and plots.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <opencv2/imgcodecs.hpp>

#include "tvl/base/check.h"
#include "tvl/cli/commands.h"
#include "tvl/eval/evaluation.h"
#include "tvl/eval/evaluation_text.h"
#include "tvl/io/atomic_file.h"
#include "tvl/io/trajectory_io.h"
#include "tvl/report/plot_trajectory.h"

namespace tvl {
namespace {

namespace fs = std::filesystem;

struct EvaluateArguments {
  std::vector<std::string> truths, estimates;  // in pairs
  size_t first_frame = 0;                      // of the truth, that the estimate begins with
  std::string json, plot_folder;               // empty: none
};

struct PathPair {
  std::string name;
  std::vector<Rigid3d> truth, estimate;
};

// The folder of the estimate names the drive: its file is called the same everywhere.
std::string DriveName(const std::string& estimate_path) {
  const std::string folder = fs::absolute(estimate_path).parent_path().filename().string();
  return folder.empty() ? estimate_path : folder;
}

// The truth is cut to the frames of the estimate, which may be a part of the drive.
PathPair ReadPair(const std::string& truth_path, const std::string& estimate_path, size_t first) {
  PathPair pair{DriveName(estimate_path), {}, ReadKittiPoses(estimate_path)};
  const std::vector<Rigid3d> truth = ReadKittiPoses(truth_path);
  TVL_CHECK_INPUT(first + pair.estimate.size() <= truth.size())
      << estimate_path << ": has " << pair.estimate.size() << " poses, " << truth_path << " has "
      << truth.size() << (first > 0 ? " in all" : "");
  const auto begin = truth.begin() + static_cast<std::ptrdiff_t>(first);
  pair.truth.assign(begin, begin + static_cast<std::ptrdiff_t>(pair.estimate.size()));
  if (pair.truth.size() < truth.size()) {
    std::cerr << "tvl: " << pair.name << ": frames " << first << " to "
              << first + pair.truth.size() - 1 << " of " << truth.size() << " are evaluated\n";
  }
  return pair;
}

std::vector<Rigid3d> Moved(std::vector<Rigid3d> poses, const Rigid3d& T_new_old) {
  for (Rigid3d& pose : poses) pose = T_new_old * pose;
  return poses;
}

void WritePicture(const fs::path& path, const cv::Mat& picture) {
  WriteAtomicallyByName(path.string(), [&](const std::string& temporary) {
    TVL_CHECK_INPUT(cv::imwrite(temporary, picture)) << path.string() << ": cannot be written";
  });
  std::cout << "wrote " << path.string() << "\n";
}

void WritePlots(const fs::path& folder, const PathPair& pair) {
  const Rigid3d T_first = AlignFirstPose(pair.truth, pair.estimate);
  const Rigid3d T_aligned = AlignPositions(pair.truth, pair.estimate);
  const std::vector<NamedPath> paths = {{"truth", pair.truth},
                                        {"estimate", Moved(pair.estimate, T_first)}};
  const std::string head = pair.name + ": ";
  WritePicture(folder / (pair.name + "_top_view.png"),
               DrawTopView(head + "trajectory from above", paths));
  WritePicture(folder / (pair.name + "_height.png"), DrawHeights(head + "height", paths));
  WritePicture(
      folder / (pair.name + "_error.png"),
      DrawErrors(head + "position error along time",
                 {{"first poses aligned", PositionErrors_m(pair.truth, pair.estimate, T_first)},
                  {"all positions aligned (ATE)",
                   PositionErrors_m(pair.truth, pair.estimate, T_aligned)}}));
}

void RunEvaluate(const EvaluateArguments& arguments) {
  TVL_CHECK_INPUT(arguments.truths.size() == arguments.estimates.size())
      << "--truth, --estimate: want as many of the one as of the other, are "
      << arguments.truths.size() << " and " << arguments.estimates.size();
  std::vector<DriveEvaluation> drives;
  for (size_t i = 0; i < arguments.truths.size(); ++i) {
    const PathPair pair =
        ReadPair(arguments.truths[i], arguments.estimates[i], arguments.first_frame);
    drives.push_back(EvaluateDrive(pair.name, pair.truth, pair.estimate));
    if (!arguments.plot_folder.empty()) WritePlots(arguments.plot_folder, pair);
  }
  const Evaluation evaluation = Combine(std::move(drives));
  std::cout << ToTable(evaluation);
  if (!arguments.json.empty()) {
    WriteAtomically(arguments.json, [&](std::ostream& out) { out << ToJson(evaluation); });
  }
}

}  // namespace

void AddEvaluateCommand(CLI::App& app) {
  auto* command = app.add_subcommand("evaluate", "Trajectories against their truth");
  const auto arguments = std::make_shared<EvaluateArguments>();
  command
      ->add_option("--truth", arguments->truths,
                   "True poses of camera 0, 3x4 a line (KITTI); several for several drives")
      ->required();
  command
      ->add_option("--estimate", arguments->estimates,
                   "Estimated poses, e.g. DIR/trajectory_kitti.txt; one for each --truth")
      ->required();
  command->add_option("--first", arguments->first_frame,
                      "Frame of the truth that the estimate begins with");
  command->add_option("--json", arguments->json, "Also write the figures to this file");
  command->add_option("--plot", arguments->plot_folder, "Also draw plots into this folder");
  command->callback([arguments] { RunEvaluate(*arguments); });
}

}  // namespace tvl
