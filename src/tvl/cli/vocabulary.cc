// tvl vocabulary: trains, describes and compares the visual vocabularies of loop detection.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>
#include <thread>

#include "tvl/base/check.h"
#include "tvl/base/stopwatch.h"
#include "tvl/cli/commands.h"
#include "tvl/cli/image_descriptors.h"
#include "tvl/cli/progress.h"
#include "tvl/io/atomic_file.h"
#include "tvl/loop/visual_database.h"
#include "tvl/loop/vocabulary_file.h"

namespace tvl {
namespace {

constexpr const char* kBuiltIn = "default";

struct TrainArguments {
  std::vector<std::string> images;
  std::string out;
  VocabularyOptions options;
  uint64_t seed = 1;
  size_t stride = 1;
};

struct CompareArguments {
  std::vector<std::string> images, vocabularies, outs;
  size_t stride = 1;
  int repeat = 1;
};

std::vector<std::vector<BinaryDescriptor>> Describe(const std::vector<std::string>& specs,
                                                    size_t stride) {
  const std::vector<ImageSource> images = FindImages(specs, stride);
  const Executor executor(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  Progress progress(std::cerr, StderrIsTerminal(), "images", images.size());
  return DescribeImages(images, executor, [&](size_t done) { progress.Update(done, "describe"); });
}

void PrintInfo(const Vocabulary& vocabulary, std::ostream& out) {
  size_t leaves_above = 0;
  double weight_sum = 0.0;
  for (const int32_t leaf : vocabulary.leaf_of_word()) {
    int depth = 0;
    for (int32_t at = leaf; at > 0; at = vocabulary.nodes()[static_cast<size_t>(at)].parent) {
      ++depth;
    }
    leaves_above += depth < vocabulary.levels() ? 1 : 0;
    weight_sum += vocabulary.nodes()[static_cast<size_t>(leaf)].weight;
  }
  out << "  tree       k " << vocabulary.branching() << ", L " << vocabulary.levels() << ", "
      << vocabulary.nodes().size() - 1 << " nodes\n"
      << "  words      " << vocabulary.words() << ", " << leaves_above
      << " of them above the last level\n"
      << "  weights    tf-idf, mean " << std::setprecision(3)
      << weight_sum / static_cast<double>(vocabulary.words()) << "\n"
      << "  score      L1\n";
}

Vocabulary Open(const std::string& file) {
  return file == kBuiltIn ? DefaultVocabulary() : ReadVocabulary(file);
}

void Train(const TrainArguments& arguments) {
  arguments.options.Check();
  const auto descriptors = Describe(arguments.images, arguments.stride);
  const Stopwatch watch;
  const Vocabulary vocabulary = Vocabulary::Train(descriptors, arguments.options, arguments.seed);
  WriteAtomically(arguments.out, [&](std::ostream& out) { WriteVocabulary(vocabulary, out); });
  std::cout << "trained on " << descriptors.size() << " images in " << std::fixed
            << std::setprecision(1) << watch.ElapsedMs() / 1000.0 << " s: " << arguments.out << "\n"
            << std::defaultfloat;
  PrintInfo(vocabulary, std::cout);
}

// Lines of "a,b,similarity" for the images in order, b before a; similarity as it is proposed by:
// over that of a and its predecessor.
void WriteSimilarities(const VisualDatabase& database, std::ostream& out) {
  out << "image,earlier,similarity\n";
  for (int a = 1; a < database.size(); ++a) {
    const double reference = Similarity(database.bag(a), database.bag(a - 1));
    if (reference <= 0.0) continue;
    for (const VisualMatch& match : database.Query(a, a)) {
      out << a << "," << match.keyframe << "," << match.similarity / reference << "\n";
    }
  }
}

// Milliseconds of a query over all images, for the last 200 of them, ascending.
std::vector<double> TimeQueries(const VisualDatabase& database) {
  std::vector<double> times_ms;
  for (int a = std::max(0, database.size() - 200); a < database.size(); ++a) {
    const Stopwatch watch;
    database.Query(a, database.size());
    times_ms.push_back(watch.ElapsedMs());
  }
  std::sort(times_ms.begin(), times_ms.end());
  return times_ms;
}

using Descriptors = std::vector<std::vector<BinaryDescriptor>>;

void CompareWith(const std::string& vocabulary, const std::string& out, const Descriptors& images,
                 int repeat) {
  VisualDatabase database(std::make_shared<const Vocabulary>(Open(vocabulary)), 1);
  for (const auto& image : images) database.Add(image);
  WriteAtomically(out, [&](std::ostream& file) { WriteSimilarities(database, file); });
  for (int i = 1; i < repeat; ++i) {
    for (const auto& image : images) database.Add(image);
  }
  const std::vector<double> times_ms = TimeQueries(database);
  std::cout << vocabulary << ": compared " << images.size() << " images: " << out << "\n"
            << std::setprecision(3) << "  query      p50 " << times_ms[times_ms.size() / 2]
            << " ms, p99 " << times_ms[times_ms.size() * 99 / 100] << " ms, at " << database.size()
            << " images\n"
            << "  memory     " << database.StateBytes() / static_cast<size_t>(database.size())
            << " bytes an image\n";
}

void Compare(const CompareArguments& arguments) {
  TVL_CHECK_INPUT(arguments.vocabularies.size() == arguments.outs.size())
      << "--vocabulary, --out: want as many of the one as of the other, are "
      << arguments.vocabularies.size() << " and " << arguments.outs.size();
  const Descriptors images = Describe(arguments.images, arguments.stride);
  TVL_CHECK_INPUT(!images.empty()) << "no images";
  for (size_t i = 0; i < arguments.outs.size(); ++i) {
    CompareWith(arguments.vocabularies[i], arguments.outs[i], images, arguments.repeat);
  }
}

void AddTrain(CLI::App& parent) {
  auto* command = parent.add_subcommand("train", "Train a vocabulary");
  const auto arguments = std::make_shared<TrainArguments>();
  VocabularyOptions& o = arguments->options;
  command
      ->add_option("images", arguments->images,
                   "Image files, folders of them, or inputs: a KITTI folder, sim:PRESET?...")
      ->required();
  command->add_option("--out", arguments->out, "File to write")->required();
  command->add_option("--branching", o.branching, "Children of a node")->capture_default_str();
  command->add_option("--levels", o.levels, "Below the root")->capture_default_str();
  command->add_option("--seed", arguments->seed, "Of the clustering")->capture_default_str();
  command->add_option("--stride", arguments->stride, "Use every so many-th image of each")
      ->capture_default_str();
  command->callback([arguments] { Train(*arguments); });
}

void AddInfo(CLI::App& parent) {
  auto* command = parent.add_subcommand("info", "What a vocabulary file holds");
  const auto file = std::make_shared<std::string>();
  command->add_option("file", *file, "A file, or `default`: the built-in one")->required();
  command->callback([file] {
    const Vocabulary vocabulary = Open(*file);
    std::cout << *file << "\n";
    PrintInfo(vocabulary, std::cout);
  });
}

void AddCompare(CLI::App& parent) {
  auto* command =
      parent.add_subcommand("compare", "How alike a vocabulary finds each two of many images");
  const auto arguments = std::make_shared<CompareArguments>();
  command->add_option("images", arguments->images, "As for train; in the order driven")->required();
  command
      ->add_option("--vocabulary", arguments->vocabularies,
                   "A file, or `default`: the built-in one; several to compare them")
      ->required();
  command
      ->add_option("--out", arguments->outs,
                   "Table to write (CSV): similarity over that to the predecessor; one for each "
                   "--vocabulary")
      ->required();
  command->add_option("--stride", arguments->stride, "Use every so many-th image of each")
      ->capture_default_str();
  command
      ->add_option("--repeat", arguments->repeat,
                   "Time queries with the images this many times over")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  command->callback([arguments] { Compare(*arguments); });
}

}  // namespace

void AddVocabularyCommand(CLI::App& app) {
  auto* command = app.add_subcommand("vocabulary", "Visual vocabularies of loop detection");
  command->require_subcommand(1);
  AddTrain(*command);
  AddInfo(*command);
  AddCompare(*command);
}

}  // namespace tvl
