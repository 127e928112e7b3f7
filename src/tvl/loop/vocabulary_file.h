// Vocabularies in files: the binary layout that VINS uses for DBoW2's.
//
// Little-endian, without padding:
//   int32 k, L, scoring (0: L1), weighting (0: tf-idf), nodes, words
//   nodes (all but the root, which is 0): int32 id, int32 parent, double weight, uint64 bits[4]
//   words: int32 node, int32 word
// Ids may come in any order. A vocabulary made with other descriptors can be read but is of no use:
// the words of our BRIEF pattern (vision/brief.h) mean something else.
#pragma once

#include <iosfwd>
#include <string>

#include "tvl/loop/vocabulary.h"

namespace tvl {

// Throws InputError naming the file and what is wrong: not there, truncated, not a tree, words that
// are not its leaves, a score other than L1 or weights other than tf-idf.
Vocabulary ReadVocabulary(const std::string& path);

// The same from memory; `name` stands for the file in errors.
Vocabulary ParseVocabulary(const std::string& bytes, const std::string& name);

// Word numbers are kept; nodes are numbered level by level.
void WriteVocabulary(const Vocabulary& vocabulary, std::ostream& out);

// config/vocabulary.bin as built into the program: trained on 500 simulated images, by
//   tvl vocabulary train "sim:city?seed=901&frames=400" "sim:traffic?seed=902&frames=400"
//     "sim:city?seed=903&frames=400" "sim:aliasing?seed=904&frames=400"
//     "sim:open?seed=905&frames=400" "sim:reverse?seed=906&frames=400"
//     "sim:loop?seed=907&frames=400" "sim:city?seed=908&frames=400"
//     "sim:city?seed=909&frames=400" "sim:city?seed=910&frames=400"
//     --stride 8 --out config/vocabulary.bin
// Nothing reported is measured on these seeds. It depends on ImageFeatureOptions' defaults.
Vocabulary DefaultVocabulary();

}  // namespace tvl
