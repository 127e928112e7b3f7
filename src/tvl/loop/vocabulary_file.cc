#include "tvl/loop/vocabulary_file.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>

#include "tvl/base/check.h"
#include "tvl/loop/embedded_vocabulary.h"

namespace tvl {
namespace {

struct FileHeader {
  int32_t branching, levels, scoring, weighting, nodes, words;
};
struct FileNode {
  int32_t id, parent;
  double weight;
  BinaryDescriptor descriptor;
};
struct FileWord {
  int32_t node, word;
};
static_assert(sizeof(FileHeader) == 24 && sizeof(FileNode) == 48 && sizeof(FileWord) == 8);

constexpr int32_t kScoringL1 = 0;
constexpr int32_t kWeightingTfIdf = 0;

// The contents of a file before they are known to be a vocabulary.
struct FileContents {
  FileHeader header{};
  std::vector<FileNode> nodes;
  std::vector<FileWord> words;
};

void CheckHeader(const FileHeader& h, size_t bytes, const std::string& name) {
  TVL_CHECK_INPUT(h.branching >= 1 && h.levels >= 1 && h.nodes >= 1 && h.words >= 1)
      << name << ": not a vocabulary (k " << h.branching << ", L " << h.levels << ", " << h.nodes
      << " nodes, " << h.words << " words)";
  TVL_CHECK_INPUT(h.scoring == kScoringL1) << name << ": scoring " << h.scoring << ", want 0 (L1)";
  TVL_CHECK_INPUT(h.weighting == kWeightingTfIdf)
      << name << ": weighting " << h.weighting << ", want 0 (tf-idf)";
  const size_t want = sizeof(FileHeader) + static_cast<size_t>(h.nodes) * sizeof(FileNode) +
                      static_cast<size_t>(h.words) * sizeof(FileWord);
  TVL_CHECK_INPUT(bytes == want) << name << ": has " << bytes << " bytes, its header says " << want;
}

FileContents Split(const std::string& bytes, const std::string& name) {
  FileContents contents;
  TVL_CHECK_INPUT(bytes.size() >= sizeof(FileHeader))
      << name << ": too short for a vocabulary (" << bytes.size() << " bytes)";
  std::memcpy(&contents.header, bytes.data(), sizeof(FileHeader));
  CheckHeader(contents.header, bytes.size(), name);
  contents.nodes.resize(static_cast<size_t>(contents.header.nodes));
  contents.words.resize(static_cast<size_t>(contents.header.words));
  const char* at = bytes.data() + sizeof(FileHeader);
  std::memcpy(contents.nodes.data(), at, contents.nodes.size() * sizeof(FileNode));
  at += contents.nodes.size() * sizeof(FileNode);
  std::memcpy(contents.words.data(), at, contents.words.size() * sizeof(FileWord));
  return contents;
}

// For every id, where its node stands in the file; and the ids of its children in file order.
struct Family {
  std::vector<int64_t> place;
  std::vector<std::vector<int32_t>> children;
};

Family FindFamily(const std::vector<FileNode>& nodes, const std::string& name) {
  const auto count = static_cast<int32_t>(nodes.size());
  Family family;
  family.place.assign(nodes.size() + 1, -1);
  family.children.resize(nodes.size() + 1);
  for (size_t i = 0; i < nodes.size(); ++i) {
    const FileNode& node = nodes[i];
    TVL_CHECK_INPUT(node.id >= 1 && node.id <= count && node.parent >= 0 && node.parent <= count)
        << name << ": node " << i << ": id " << node.id << ", parent " << node.parent << " of "
        << count << " nodes";
    TVL_CHECK_INPUT(family.place[static_cast<size_t>(node.id)] < 0)
        << name << ": id " << node.id << " is there twice";
    TVL_CHECK_INPUT(std::isfinite(node.weight) && node.weight >= 0.0)
        << name << ": node " << node.id << ": weight " << node.weight;
    family.place[static_cast<size_t>(node.id)] = static_cast<int64_t>(i);
    family.children[static_cast<size_t>(node.parent)].push_back(node.id);
  }
  return family;
}

std::vector<int32_t> WordOfNode(const FileContents& contents, const Family& family,
                                const std::string& name) {
  std::vector<int32_t> word_of(contents.nodes.size() + 1, -1);
  std::vector<bool> seen(contents.words.size(), false);
  const auto nodes = static_cast<int32_t>(contents.nodes.size());
  const auto words = static_cast<int32_t>(contents.words.size());
  for (const FileWord& w : contents.words) {
    TVL_CHECK_INPUT(w.node >= 1 && w.node <= nodes && w.word >= 0 && w.word < words &&
                    !seen[static_cast<size_t>(w.word)] &&
                    word_of[static_cast<size_t>(w.node)] < 0 &&
                    family.children[static_cast<size_t>(w.node)].empty())
        << name << ": word " << w.word << " at node " << w.node << " is not a leaf of its own";
    seen[static_cast<size_t>(w.word)] = true;
    word_of[static_cast<size_t>(w.node)] = w.word;
  }
  return word_of;
}

}  // namespace

Vocabulary ParseVocabulary(const std::string& bytes, const std::string& name) {
  const FileContents contents = Split(bytes, name);
  const Family family = FindFamily(contents.nodes, name);
  const std::vector<int32_t> word_of = WordOfNode(contents, family, name);
  std::vector<VocabularyNode> nodes(1);
  std::vector<int32_t> ids = {0};  // of `nodes`
  for (size_t i = 0; i < nodes.size(); ++i) {
    const std::vector<int32_t>& children = family.children[static_cast<size_t>(ids[i])];
    nodes[i].first_child = children.empty() ? 0 : static_cast<int32_t>(nodes.size());
    nodes[i].children = static_cast<int32_t>(children.size());
    nodes[i].word = word_of[static_cast<size_t>(ids[i])];
    TVL_CHECK_INPUT(!children.empty() || nodes[i].word >= 0)
        << name << ": node " << ids[i] << " is a leaf without a word";
    for (const int32_t id : children) {
      const FileNode& node =
          contents.nodes[static_cast<size_t>(family.place[static_cast<size_t>(id)])];
      nodes.push_back({static_cast<int32_t>(i), 0, 0, -1, node.weight, node.descriptor});
      ids.push_back(id);
    }
  }
  TVL_CHECK_INPUT(nodes.size() == contents.nodes.size() + 1)
      << name << ": only " << nodes.size() - 1 << " of " << contents.nodes.size()
      << " nodes hang on the root";
  Vocabulary vocabulary(contents.header.branching, contents.header.levels, std::move(nodes));
  TVL_CHECK_INPUT(vocabulary.HasWeights()) << name << ": no word has a weight";
  return vocabulary;
}

Vocabulary ReadVocabulary(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  TVL_CHECK_INPUT(std::filesystem::is_regular_file(path) && file.good())
      << path << ": cannot be read";
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return ParseVocabulary(bytes, path);
}

void WriteVocabulary(const Vocabulary& vocabulary, std::ostream& out) {
  const auto write = [&](const auto& value) {
    out.write(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  const std::vector<VocabularyNode>& nodes = vocabulary.nodes();
  write(FileHeader{vocabulary.branching(), vocabulary.levels(), kScoringL1, kWeightingTfIdf,
                   static_cast<int32_t>(nodes.size() - 1), vocabulary.words()});
  for (size_t i = 1; i < nodes.size(); ++i) {
    write(FileNode{static_cast<int32_t>(i), nodes[i].parent, nodes[i].weight, nodes[i].descriptor});
  }
  for (int32_t word = 0; word < vocabulary.words(); ++word) {
    write(FileWord{vocabulary.leaf_of_word()[static_cast<size_t>(word)], word});
  }
}

Vocabulary DefaultVocabulary() {
  return ParseVocabulary(EmbeddedVocabulary(), "built-in vocabulary");
}

}  // namespace tvl
