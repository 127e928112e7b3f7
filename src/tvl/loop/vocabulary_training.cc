// Vocabulary::Train: hierarchical k-medians.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "tvl/base/check.h"
#include "tvl/base/rng.h"
#include "tvl/loop/hamming.h"
#include "tvl/loop/vocabulary.h"

namespace tvl {
namespace {

using Descriptors = std::vector<BinaryDescriptor>;

// Bit by bit what most have; a tie is 0.
BinaryDescriptor Majority(const Descriptors& members) {
  std::array<size_t, 256> ones{};
  for (const BinaryDescriptor& d : members) {
    for (size_t bit = 0; bit < 256; ++bit) ones[bit] += (d[bit / 64] >> (bit % 64)) & 1;
  }
  BinaryDescriptor majority{};
  for (size_t bit = 0; bit < 256; ++bit) {
    if (2 * ones[bit] > members.size()) majority[bit / 64] |= uint64_t{1} << (bit % 64);
  }
  return majority;
}

// The index drawn with a probability proportional to its weight. Some weight is positive.
size_t Draw(const std::vector<double>& weights, Rng& rng) {
  double left = rng.Uniform() * std::accumulate(weights.begin(), weights.end(), 0.0);
  size_t last = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] <= 0.0) continue;
    last = i;
    left -= weights[i];
    if (left < 0.0) break;
  }
  return last;
}

// Up to k different members, far from each other with a higher probability (k-means++).
Descriptors FirstCentres(const Descriptors& members, int k, Rng& rng) {
  Descriptors centres;
  std::vector<double> distance_sq(members.size(), 1.0);
  while (static_cast<int>(centres.size()) < k &&
         *std::max_element(distance_sq.begin(), distance_sq.end()) > 0.0) {
    const BinaryDescriptor centre = members[Draw(distance_sq, rng)];
    for (size_t i = 0; i < members.size(); ++i) {
      const double d = HammingDistance(members[i], centre);
      distance_sq[i] = centres.empty() ? d * d : std::min(distance_sq[i], d * d);
    }
    centres.push_back(centre);
  }
  return centres;
}

// Members by their nearest centre; the first of equals.
std::vector<Descriptors> Assign(const Descriptors& members, const Descriptors& centres) {
  std::vector<Descriptors> groups(centres.size());
  for (const BinaryDescriptor& d : members) {
    size_t nearest = 0;
    int best = 257;
    for (size_t c = 0; c < centres.size(); ++c) {
      const int distance = HammingDistance(d, centres[c]);
      if (distance < best) {
        best = distance;
        nearest = c;
      }
    }
    groups[nearest].push_back(d);
  }
  return groups;
}

struct Cluster {
  BinaryDescriptor centre;
  Descriptors members;
};

// At most k clusters, none empty. Fewer if there are fewer different members.
std::vector<Cluster> SplitIntoClusters(const Descriptors& members, const VocabularyOptions& options,
                                       Rng& rng) {
  Descriptors centres = FirstCentres(members, options.branching, rng);
  std::vector<Descriptors> groups = Assign(members, centres);
  for (int i = 0; i < options.max_iterations; ++i) {
    Descriptors moved = centres;
    for (size_t c = 0; c < centres.size(); ++c) {
      if (!groups[c].empty()) moved[c] = Majority(groups[c]);
    }
    if (moved == centres) break;
    centres = moved;
    groups = Assign(members, centres);
  }
  std::vector<Cluster> clusters;
  for (size_t c = 0; c < centres.size(); ++c) {
    if (!groups[c].empty()) clusters.push_back({centres[c], std::move(groups[c])});
  }
  return clusters;
}

// The tree, level by level, so that siblings stand together; words are numbered as they come.
std::vector<VocabularyNode> Grow(const Descriptors& all, const VocabularyOptions& options,
                                 Rng& rng) {
  std::vector<VocabularyNode> nodes(1);
  std::vector<Descriptors> level = {all};  // members of the last nodes
  for (int depth = 0; depth < options.levels; ++depth) {
    std::vector<Descriptors> next;
    const size_t first = nodes.size() - level.size();
    for (size_t i = 0; i < level.size(); ++i) {
      std::vector<Cluster> clusters = SplitIntoClusters(level[i], options, rng);
      // A node that cannot be split stays a leaf; the root always gets a child.
      if (clusters.size() < 2 && depth > 0) continue;
      nodes[first + i].first_child = static_cast<int32_t>(nodes.size());
      nodes[first + i].children = static_cast<int32_t>(clusters.size());
      for (Cluster& cluster : clusters) {
        VocabularyNode child;
        child.parent = static_cast<int32_t>(first + i);
        child.descriptor = cluster.centre;
        nodes.push_back(child);
        next.push_back(std::move(cluster.members));
      }
    }
    level = std::move(next);
    if (level.empty()) break;
  }
  int32_t word = 0;
  for (VocabularyNode& node : nodes) {
    if (node.children == 0) node.word = word++;
  }
  return nodes;
}

// Inverse document frequencies: log(images / images with the word).
std::vector<double> WeighWords(const Vocabulary& vocabulary,
                               const std::vector<Descriptors>& images) {
  std::vector<int> images_with(static_cast<size_t>(vocabulary.words()), 0);
  for (const Descriptors& image : images) {
    std::vector<int32_t> words;
    for (const BinaryDescriptor& d : image) words.push_back(vocabulary.Find(d, 0).word);
    std::sort(words.begin(), words.end());
    words.erase(std::unique(words.begin(), words.end()), words.end());
    for (const int32_t word : words) ++images_with[static_cast<size_t>(word)];
  }
  std::vector<double> weights;
  for (const int count : images_with) {
    weights.push_back(std::log(static_cast<double>(images.size()) / std::max(1, count)));
  }
  return weights;
}

}  // namespace

Vocabulary Vocabulary::Train(const std::vector<Descriptors>& images,
                             const VocabularyOptions& options, uint64_t seed) {
  options.Check();
  Descriptors all;
  for (const Descriptors& image : images) all.insert(all.end(), image.begin(), image.end());
  const auto usable = std::count_if(images.begin(), images.end(),
                                    [](const Descriptors& image) { return !image.empty(); });
  TVL_CHECK_INPUT(usable >= 2) << "vocabulary: " << usable << " of " << images.size()
                               << " images have features to train on, needs at least 2";
  Rng rng(seed);
  std::vector<VocabularyNode> nodes = Grow(all, options, rng);
  const std::vector<double> weights =
      WeighWords(Vocabulary(options.branching, options.levels, nodes), images);
  for (VocabularyNode& node : nodes) {
    if (node.children == 0) node.weight = weights[static_cast<size_t>(node.word)];
  }
  Vocabulary vocabulary(options.branching, options.levels, std::move(nodes));
  TVL_CHECK_INPUT(vocabulary.HasWeights())
      << "vocabulary: all " << vocabulary.words() << " words are in each of the " << images.size()
      << " images: nothing tells one from another";
  return vocabulary;
}

}  // namespace tvl
