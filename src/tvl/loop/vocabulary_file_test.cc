#include "tvl/loop/vocabulary_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <sstream>

#include "tvl/base/check.h"
#include "tvl/io/temp_folder.h"
#include "tvl/loop/test_places.h"

namespace tvl {
namespace {

using testing::HasSubstr;

Vocabulary MakeVocabulary() {
  Rng rng(1);
  std::vector<std::vector<BinaryDescriptor>> images(12);
  for (auto& image : images) {
    for (int i = 0; i < 40; ++i) image.push_back(RandomDescriptor(rng));
  }
  VocabularyOptions options;
  options.branching = 4;
  options.levels = 3;
  return Vocabulary::Train(images, options, 1);
}

std::string BytesOf(const Vocabulary& vocabulary) {
  std::ostringstream out;
  WriteVocabulary(vocabulary, out);
  return out.str();
}

template <typename T>
void Put(std::string& bytes, size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

template <typename T>
T Get(const std::string& bytes, size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

std::string ErrorOf(const std::string& bytes) {
  try {
    ParseVocabulary(bytes, "voc.bin");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(VocabularyFile, LayoutIsThatOfVins) {
  const Vocabulary vocabulary = MakeVocabulary();
  const std::string bytes = BytesOf(vocabulary);
  const auto nodes = static_cast<int32_t>(vocabulary.nodes().size() - 1);
  EXPECT_EQ(bytes.size(),
            24U + 48U * static_cast<size_t>(nodes) + 8U * static_cast<size_t>(vocabulary.words()));
  EXPECT_EQ(Get<int32_t>(bytes, 0), 4);
  EXPECT_EQ(Get<int32_t>(bytes, 4), 3);
  EXPECT_EQ(Get<int32_t>(bytes, 8), 0);
  EXPECT_EQ(Get<int32_t>(bytes, 12), 0);
  EXPECT_EQ(Get<int32_t>(bytes, 16), nodes);
  EXPECT_EQ(Get<int32_t>(bytes, 20), vocabulary.words());
  const VocabularyNode& fifth = vocabulary.nodes()[5];
  EXPECT_EQ(Get<int32_t>(bytes, 24 + 4 * 48), 5);
  EXPECT_EQ(Get<int32_t>(bytes, 24 + 4 * 48 + 4), fifth.parent);
  EXPECT_EQ(Get<double>(bytes, 24 + 4 * 48 + 8), fifth.weight);
  EXPECT_EQ(Get<uint64_t>(bytes, 24 + 4 * 48 + 16 + 16), fifth.descriptor[2]);
}

TEST(VocabularyFile, RoundTripKeepsEveryByte) {
  const std::string bytes = BytesOf(MakeVocabulary());
  const TempFolder folder;
  EXPECT_EQ(BytesOf(ReadVocabulary(folder.Write("voc.bin", bytes))), bytes);
}

TEST(VocabularyFile, NodesMayComeInAnyOrder) {
  const Vocabulary vocabulary = MakeVocabulary();
  const std::string bytes = BytesOf(vocabulary);
  const size_t nodes = vocabulary.nodes().size() - 1;
  std::string turned = bytes;  // the list of nodes turned round: children before their parents
  for (size_t i = 0; i < nodes; ++i) {
    std::memcpy(turned.data() + 24 + 48 * (nodes - 1 - i), bytes.data() + 24 + 48 * i, 48);
  }
  const Vocabulary back = ParseVocabulary(turned, "turned");
  ASSERT_EQ(back.words(), vocabulary.words());
  const auto way_to = [](const Vocabulary& v, size_t word) {
    std::vector<std::pair<BinaryDescriptor, double>> way;
    for (int32_t at = v.leaf_of_word()[word]; at > 0;
         at = v.nodes()[static_cast<size_t>(at)].parent) {
      const VocabularyNode& node = v.nodes()[static_cast<size_t>(at)];
      way.emplace_back(node.descriptor, node.weight);
    }
    return way;
  };
  for (size_t word = 0; word < static_cast<size_t>(vocabulary.words()); ++word) {
    EXPECT_EQ(way_to(back, word), way_to(vocabulary, word));
  }
}

TEST(VocabularyFile, DamagedFilesAreRefusedByName) {
  const std::string good = BytesOf(MakeVocabulary());
  const size_t first_word = good.size() - 8 * static_cast<size_t>(Get<int32_t>(good, 20));
  EXPECT_THAT(ErrorOf(""), HasSubstr("voc.bin: too short"));
  EXPECT_THAT(ErrorOf(good.substr(0, good.size() - 1)), HasSubstr("its header says"));
  EXPECT_THAT(ErrorOf(std::string(100, '\0')), HasSubstr("not a vocabulary"));
  EXPECT_THAT(ErrorOf(std::string(100, '\xff')), HasSubstr("not a vocabulary"));
  const auto with = [&](size_t at, int32_t value) {
    std::string bytes = good;
    Put(bytes, at, value);
    return ErrorOf(bytes);
  };
  EXPECT_THAT(with(8, 5), HasSubstr("scoring 5"));
  EXPECT_THAT(with(12, 3), HasSubstr("weighting 3"));
  EXPECT_THAT(with(16, 7), HasSubstr("its header says"));
  EXPECT_THAT(with(24 + 48, 1), HasSubstr("id 1 is there twice"));
  EXPECT_THAT(with(24, 1 << 20), HasSubstr("id 1048576"));
  EXPECT_THAT(with(24 + 4, -2), HasSubstr("parent -2"));
  EXPECT_THAT(with(24 + 4, 1), HasSubstr("hang on the root"));  // its own parent
  EXPECT_THAT(with(first_word + 4, 1), HasSubstr("not a leaf of its own"));
  EXPECT_THAT(with(first_word, 1), HasSubstr("not a leaf of its own"));
  std::string bytes = good;
  Put(bytes, 24 + 8, std::nan(""));
  EXPECT_THAT(ErrorOf(bytes), HasSubstr("weight"));
}

// Such a vocabulary finds nothing and does not say so.
TEST(VocabularyFile, WithoutAnyWeightIsRefused) {
  std::string bytes = BytesOf(MakeVocabulary());
  const auto nodes = static_cast<size_t>(Get<int32_t>(bytes, 16));
  for (size_t i = 0; i < nodes; ++i) Put(bytes, 24 + 48 * i + 8, 0.0);
  EXPECT_THAT(ErrorOf(bytes), HasSubstr("voc.bin: no word has a weight"));
}

TEST(VocabularyFile, MissingFileIsNamed) {
  try {
    ReadVocabulary("no/such.bin");
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("no/such.bin"));
  }
}

TEST(VocabularyFile, TheBuiltInOneIsSmallAndHasFourLevelsOfTen) {
  const Vocabulary vocabulary = DefaultVocabulary();
  EXPECT_EQ(vocabulary.branching(), 10);
  EXPECT_EQ(vocabulary.levels(), 4);
  EXPECT_GT(vocabulary.words(), 9000);
  EXPECT_LE(BytesOf(vocabulary).size(), 1000000U);
}

}  // namespace
}  // namespace tvl
