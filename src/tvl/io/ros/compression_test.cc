#include "tvl/io/ros/compression.h"

#include <bzlib.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <zstd.h>

#include <memory>

#include "tvl/base/check.h"
#include "tvl/io/ros/chunk_reader.h"

namespace tvl {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr size_t kPlainBytes = 3'000'000;  // several steps of every kind

Bytes Plain() {
  Bytes plain(kPlainBytes);
  for (size_t k = 0; k < plain.size(); ++k) plain[k] = static_cast<uint8_t>(k * k >> 7U);
  return plain;
}

Bytes Deflate(const Bytes& plain, Compression compression) {
  Bytes stored(2 * plain.size() + 1000);
  size_t bytes = 0;
  if (compression == Compression::kLz4) {
    bytes = LZ4F_compressFrame(stored.data(), stored.size(), plain.data(), plain.size(), nullptr);
  } else if (compression == Compression::kZstd) {
    bytes = ZSTD_compress(stored.data(), stored.size(), plain.data(), plain.size(), 1);
  } else {
    Bytes copy = plain;
    auto length = static_cast<unsigned>(stored.size());
    BZ2_bzBuffToBuffCompress(reinterpret_cast<char*>(stored.data()), &length,
                             reinterpret_cast<char*>(copy.data()),
                             static_cast<unsigned>(copy.size()), 1, 0, 0);
    bytes = length;
  }
  stored.resize(bytes);
  return stored;
}

class EveryCompression : public testing::TestWithParam<Compression> {
 protected:
  Inflated InflateUpTo(const Bytes& stored, uint64_t most_bytes) const {
    const auto source = MemorySource("memory", stored.data(), stored.size());
    return Inflate(*source, 0, stored.size(), GetParam(), most_bytes);
  }
};

TEST_P(EveryCompression, InflatesAllOrAStart) {
  const Bytes plain = Plain(), stored = Deflate(plain, GetParam());
  EXPECT_EQ(InflateUpTo(stored, plain.size()).bytes, plain);
  EXPECT_EQ(InflateUpTo(stored, plain.size()).error, "");
  const Inflated start = InflateUpTo(stored, 1000);
  EXPECT_EQ(start.bytes, Bytes(plain.begin(), plain.begin() + 1000));
  EXPECT_EQ(start.error, "");
}

TEST_P(EveryCompression, MemoryGrowsWithWhatIsThereNotWithWhatIsAnnounced) {
  const Bytes plain(100, 7), stored = Deflate(plain, GetParam());
  const Inflated inflated = InflateUpTo(stored, 1'000'000 * plain.size());
  EXPECT_EQ(inflated.bytes, plain);
  EXPECT_LT(inflated.bytes.capacity(), size_t{1} << 22U);
  EXPECT_NE(inflated.error, "");
}

TEST_P(EveryCompression, CutOffDataGiveWhatComesBefore) {
  const Bytes plain = Plain();
  Bytes stored = Deflate(plain, GetParam());
  stored.resize(stored.size() * 2 / 3);
  const Inflated inflated = InflateUpTo(stored, plain.size());
  EXPECT_NE(inflated.error, "");
  ASSERT_LT(inflated.bytes.size(), plain.size());
  EXPECT_TRUE(std::equal(inflated.bytes.begin(), inflated.bytes.end(), plain.begin()));
  EXPECT_NE(InflateUpTo(Bytes(100, 0x55), 1000).error, "");
}

INSTANTIATE_TEST_SUITE_P(Libraries, EveryCompression,
                         testing::Values(Compression::kBz2, Compression::kLz4, Compression::kZstd),
                         [](const auto& test) { return std::string(ToString(test.param)); });

TEST(ChunkReader, AnnouncedSizesAreNotBelieved) {
  const Bytes plain(100, 7), stored = Deflate(plain, Compression::kLz4);
  const std::shared_ptr<const ByteSource> source =
      MemorySource("a.bag", stored.data(), stored.size());
  ChunkReader chunks(source);
  EXPECT_THROW(chunks.Add({0, stored.size() + 1, 100, Compression::kLz4}), InputError);
  EXPECT_THROW(chunks.Add({UINT64_MAX, 1, 100, Compression::kLz4}), InputError);
  EXPECT_THROW(chunks.Add({0, stored.size(), kMostMessageBytes + 1, Compression::kLz4}),
               InputError);
  const uint32_t chunk = chunks.Add({0, stored.size(), 1'000'000, Compression::kLz4});
  EXPECT_EQ(chunks.Read(chunk, 90, 10).size, 10U);
  EXPECT_THROW(chunks.Read(chunk, 90, 11), InputError);
  EXPECT_THROW(chunks.Read(chunk, UINT64_MAX, 1), InputError);
  EXPECT_EQ(chunks.ReadUpTo(chunk, 90, 1000, true).size, 10U);
}

}  // namespace
}  // namespace tvl
