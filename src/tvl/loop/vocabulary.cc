#include "tvl/loop/vocabulary.h"

#include <algorithm>
#include <cmath>

#include "tvl/base/check.h"
#include "tvl/loop/hamming.h"

namespace tvl {

void VocabularyOptions::Check() const {
  TVL_CHECK_INPUT(branching >= 2 && branching <= 100)
      << "branching: must lie in 2..100, is " << branching;
  TVL_CHECK_INPUT(levels >= 1 && levels <= 8) << "levels: must lie in 1..8, is " << levels;
  TVL_CHECK_INPUT(std::pow(branching, levels) <= 1e7)
      << "branching, levels: " << branching << "^" << levels << " words are more than 10^7";
  TVL_CHECK_INPUT(max_iterations >= 1)
      << "max_iterations: must be at least 1, is " << max_iterations;
}

double Similarity(const BagOfWords& a, const BagOfWords& b) {
  double common = 0.0;  // the sum of minima: what 1 - 0.5 |a - b| comes to
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (i->word == j->word) {
      common += static_cast<double>(std::min(i->share, j->share));
      ++i;
      ++j;
    } else if (i->word < j->word) {
      ++i;
    } else {
      ++j;
    }
  }
  return common;
}

Vocabulary::Vocabulary(int branching, int levels, std::vector<VocabularyNode> nodes)
    : branching_(branching), levels_(levels), nodes_(std::move(nodes)) {
  TVL_CHECK(nodes_.size() > 1) << "a vocabulary without words";
  const auto count = static_cast<int32_t>(nodes_.size());
  int32_t words = 0;
  for (int32_t i = 0; i < count; ++i) {
    const VocabularyNode& node = nodes_[static_cast<size_t>(i)];
    TVL_CHECK(node.parent < i && (node.parent >= 0 || i == 0)) << "parent of node " << i;
    if (node.children == 0) ++words;
    TVL_CHECK(node.children == 0 ||
              (node.first_child > i && node.first_child + node.children <= count))
        << "children of node " << i;
  }
  leaf_of_word_.assign(static_cast<size_t>(words), -1);
  for (int32_t i = 0; i < count; ++i) {
    const VocabularyNode& node = nodes_[static_cast<size_t>(i)];
    if (node.children > 0) continue;
    TVL_CHECK(node.word >= 0 && node.word < words &&
              leaf_of_word_[static_cast<size_t>(node.word)] < 0)
        << "word of node " << i;
    leaf_of_word_[static_cast<size_t>(node.word)] = i;
  }
}

WordOf Vocabulary::Find(const BinaryDescriptor& descriptor, int level) const {
  WordOf found;
  int32_t at = 0;
  for (int depth = 1; nodes_[static_cast<size_t>(at)].children > 0; ++depth) {
    const VocabularyNode& node = nodes_[static_cast<size_t>(at)];
    int best = 257;
    for (int32_t child = node.first_child; child < node.first_child + node.children; ++child) {
      const int distance =
          HammingDistance(descriptor, nodes_[static_cast<size_t>(child)].descriptor);
      if (distance < best) {
        best = distance;
        at = child;
      }
    }
    if (depth <= level) found.node = at;
  }
  found.word = nodes_[static_cast<size_t>(at)].word;
  return found;
}

bool Vocabulary::HasWeights() const {
  return std::any_of(leaf_of_word_.begin(), leaf_of_word_.end(),
                     [&](int32_t leaf) { return nodes_[static_cast<size_t>(leaf)].weight > 0.0; });
}

BagOfWords Vocabulary::Describe(const std::vector<WordOf>& words) const {
  std::vector<int32_t> sorted;
  for (const WordOf& w : words) sorted.push_back(w.word);
  std::sort(sorted.begin(), sorted.end());
  BagOfWords bag;
  double sum = 0.0;
  for (size_t i = 0; i < sorted.size();) {
    size_t end = i;
    while (end < sorted.size() && sorted[end] == sorted[i]) ++end;
    const auto leaf = static_cast<size_t>(leaf_of_word_[static_cast<size_t>(sorted[i])]);
    const double share = static_cast<double>(end - i) * nodes_[leaf].weight;
    if (share > 0.0) bag.push_back({sorted[i], static_cast<float>(share)});
    sum += share;
    i = end;
  }
  for (WordShare& w : bag) w.share = static_cast<float>(static_cast<double>(w.share) / sum);
  return bag;
}

BagOfWords Vocabulary::Describe(const std::vector<BinaryDescriptor>& descriptors) const {
  std::vector<WordOf> words;
  words.reserve(descriptors.size());
  for (const BinaryDescriptor& d : descriptors) words.push_back(Find(d, 0));
  return Describe(words);
}

}  // namespace tvl
