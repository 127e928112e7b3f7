// A visual vocabulary: a tree of binary descriptors whose leaves are the words of an image
// (Galvez-Lopez and Tardos 2012; paper 6.2).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tvl/frame/image_features.h"

namespace tvl {

struct VocabularyOptions {
  int branching = 10;  // children of a node (k)
  // Below the root (L). 10^4 words fill 613 kB; 10^6, as usual for online use, 64 MB for a few per
  // cent more recall.
  int levels = 4;
  int max_iterations = 10;  // of clustering a node's descriptors: they settle after 5 to 8

  void Check() const;  // throws InputError naming the field
};

// A word and how much of the image it makes up.
struct WordShare {
  int32_t word = 0;
  float share = 0.0f;
};

// An image: its words by ascending number, shares adding up to 1 (tf-idf). Empty if it has none.
using BagOfWords = std::vector<WordShare>;

// 1 for the same shares of the same words, 0 for none in common: 1 - 0.5 |a - b| (L1).
double Similarity(const BagOfWords& a, const BagOfWords& b);

// One node of the tree. The root is node 0 and has no descriptor.
struct VocabularyNode {
  int32_t parent = -1;
  int32_t first_child = 0, children = 0;  // numbered one after the other
  int32_t word = -1;                      // leaves: the word
  double weight = 0.0;                    // leaves: idf, log(images / images with this word)
  BinaryDescriptor descriptor{};          // the bitwise majority of what it stands for
};

// Where a descriptor ends up: its word, and the node it passed at the level asked for.
struct WordOf {
  int32_t word = 0;
  int32_t node = 0;
};

// Immutable; thread-safe.
class Vocabulary {
 public:
  // Takes a tree in which every child is numbered after its parent and siblings one after the
  // other. Throws Error for another.
  Vocabulary(int branching, int levels, std::vector<VocabularyNode> nodes);

  // Clusters all descriptors level by level (k-medians, seeded like k-means++), then weighs each
  // word by the images it is found in. Throws InputError if fewer than two images have descriptors
  // or no word tells one image from another. Deterministic.
  static Vocabulary Train(const std::vector<std::vector<BinaryDescriptor>>& images,
                          const VocabularyOptions& options, uint64_t seed);

  // Goes down the tree along the nearest child. `level` counts from the root, 0; a branch that ends
  // earlier gives its leaf.
  WordOf Find(const BinaryDescriptor& descriptor, int level) const;

  // tf-idf of the words of an image.
  BagOfWords Describe(const std::vector<WordOf>& words) const;
  BagOfWords Describe(const std::vector<BinaryDescriptor>& descriptors) const;

  // Some word has a weight. Without, every image is described by nothing.
  bool HasWeights() const;

  int branching() const { return branching_; }
  int levels() const { return levels_; }
  int words() const { return static_cast<int>(leaf_of_word_.size()); }
  const std::vector<VocabularyNode>& nodes() const { return nodes_; }
  const std::vector<int32_t>& leaf_of_word() const { return leaf_of_word_; }

 private:
  int branching_, levels_;
  std::vector<VocabularyNode> nodes_;
  std::vector<int32_t> leaf_of_word_;
};

}  // namespace tvl
