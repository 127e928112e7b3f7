// Which keyframes look like this one (paper 6.2): an inverted index over the words of their images.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "tvl/loop/vocabulary.h"

namespace tvl {

// A keyframe with words in common.
struct VisualMatch {
  int keyframe = 0;
  double similarity = 0.0;  // 0..1, see Similarity
};

// The features of an image by the node they passed at the level of the direct index, ascending:
// only features of one node are compared with each other.
struct DirectIndex {
  std::vector<int32_t> node;
  std::vector<uint16_t> feature;  // as long as node
};

// Keeps about 12 kB a keyframe of 500 features: words in the inverted index, its own bag and direct
// index. A query over 4,500 keyframes takes 0.4 ms. Copies of one state answer alike.
class VisualDatabase {
 public:
  // `direct_level`: of the tree, counted from the root.
  VisualDatabase(std::shared_ptr<const Vocabulary> vocabulary, int direct_level);

  // Keyframes are added in order, the first is 0; one without descriptors matches nothing.
  // Throws Error for more than 65536 descriptors.
  void Add(const std::vector<BinaryDescriptor>& descriptors);
  int size() const { return static_cast<int>(bags_.size()); }

  // Similarity of keyframe `query` to those before `end`: the ones with words in common, by number.
  std::vector<VisualMatch> Query(int query, int end) const;

  const BagOfWords& bag(int keyframe) const { return bags_.at(static_cast<size_t>(keyframe)); }
  const DirectIndex& direct_index(int keyframe) const {
    return direct_.at(static_cast<size_t>(keyframe));
  }
  // Memory held for keyframes, vectors' reserves included.
  size_t StateBytes() const;

 private:
  struct Posting {
    int32_t keyframe;
    float share;
  };

  std::shared_ptr<const Vocabulary> vocabulary_;
  int direct_level_;
  std::vector<std::vector<Posting>> postings_;  // a list a word, by keyframe
  std::vector<BagOfWords> bags_;
  std::vector<DirectIndex> direct_;
};

}  // namespace tvl
