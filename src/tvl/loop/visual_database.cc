#include "tvl/loop/visual_database.h"

#include <algorithm>
#include <numeric>

#include "tvl/base/check.h"

namespace tvl {
namespace {

DirectIndex MakeDirectIndex(const std::vector<WordOf>& words) {
  DirectIndex index;
  index.feature.resize(words.size());
  std::iota(index.feature.begin(), index.feature.end(), uint16_t{0});
  std::stable_sort(index.feature.begin(), index.feature.end(),
                   [&](uint16_t a, uint16_t b) { return words[a].node < words[b].node; });
  for (const uint16_t f : index.feature) index.node.push_back(words[f].node);
  return index;
}

template <typename T>
size_t Bytes(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}

}  // namespace

VisualDatabase::VisualDatabase(std::shared_ptr<const Vocabulary> vocabulary, int direct_level)
    : vocabulary_(std::move(vocabulary)),
      direct_level_(direct_level),
      postings_(static_cast<size_t>(vocabulary_->words())) {}

void VisualDatabase::Add(const std::vector<BinaryDescriptor>& descriptors) {
  TVL_CHECK(descriptors.size() <= 65536) << descriptors.size() << " descriptors in one image";
  std::vector<WordOf> words;
  words.reserve(descriptors.size());
  for (const BinaryDescriptor& d : descriptors)
    words.push_back(vocabulary_->Find(d, direct_level_));
  bags_.push_back(vocabulary_->Describe(words));
  bags_.back().shrink_to_fit();
  direct_.push_back(MakeDirectIndex(words));
  for (const WordShare& w : bags_.back()) {
    postings_[static_cast<size_t>(w.word)].push_back({size() - 1, w.share});
  }
}

std::vector<VisualMatch> VisualDatabase::Query(int query, int end) const {
  TVL_CHECK(end >= 0 && end <= size()) << end << " of " << size();
  std::vector<float> common(static_cast<size_t>(end), 0.0f);
  for (const WordShare& w : bag(query)) {
    for (const Posting& p : postings_[static_cast<size_t>(w.word)]) {
      if (p.keyframe >= end) break;
      common[static_cast<size_t>(p.keyframe)] += std::min(w.share, p.share);
    }
  }
  std::vector<VisualMatch> matches;
  for (int i = 0; i < end; ++i) {
    const float similarity = common[static_cast<size_t>(i)];
    if (similarity > 0.0f) matches.push_back({i, static_cast<double>(similarity)});
  }
  return matches;
}

size_t VisualDatabase::StateBytes() const {
  size_t bytes = 0;
  for (const auto& list : postings_) bytes += Bytes(list);
  for (const BagOfWords& bag : bags_) bytes += Bytes(bag) + sizeof(BagOfWords);
  for (const DirectIndex& index : direct_) {
    bytes += Bytes(index.node) + Bytes(index.feature) + sizeof(DirectIndex);
  }
  return bytes;
}

}  // namespace tvl
