#include "tvl/io/ros/wire.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tvl/base/check.h"
#include "tvl/io/ros/test_bags.h"

namespace tvl {
namespace {

using testing::HasSubstr;

template <typename Function>
std::string TextOfError(const Function& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(WireReader, ReadsRos1WithoutPadding) {
  const std::vector<uint8_t> bytes =
      BytesBuilder().Add<uint8_t>(3).Add<double>(0.25).Text("lidar").Add<int16_t>(-2).bytes();
  WireReader reader(bytes.data(), bytes.size(), MessageEncoding::kRos1, "bag");
  EXPECT_EQ(reader.Number<uint8_t>(), 3);
  EXPECT_EQ(reader.Number<double>(), 0.25);
  EXPECT_EQ(reader.String(), "lidar");
  EXPECT_EQ(reader.Number<int16_t>(), -2);
  EXPECT_EQ(reader.remaining(), 0U);
}

TEST(WireReader, CdrAlignsFromTheEndOfItsHeader) {
  const std::vector<uint8_t> bytes = {0, 1, 0, 0, 9,   0,   0, 0,  1, 2, 0, 0,  // uint8, uint32
                                      0, 0, 0, 0, 0,   0,   0, 64,              // double 2.0
                                      3, 0, 0, 0, 'a', 'b', 0};                 // text
  WireReader reader(bytes.data(), bytes.size(), MessageEncoding::kCdr, "bag");
  EXPECT_EQ(reader.Number<uint8_t>(), 9);
  EXPECT_EQ(reader.Number<uint32_t>(), 0x0201U);
  EXPECT_EQ(reader.Number<double>(), 2.0);
  EXPECT_EQ(reader.String(), "ab");
}

TEST(WireReader, CdrMayBeBigEndian) {
  const std::vector<uint8_t> bytes = {0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 2};
  WireReader reader(bytes.data(), bytes.size(), MessageEncoding::kCdr, "bag");
  EXPECT_TRUE(reader.big_endian());
  EXPECT_EQ(reader.Number<uint16_t>(), 1);
  EXPECT_EQ(reader.Number<uint32_t>(), 2U);
}

TEST(WireReader, EndsAreErrorsThatNameTheByte) {
  const std::vector<uint8_t> bytes = {1, 2, 3};
  WireReader reader(bytes.data(), bytes.size(), MessageEncoding::kRos1, "a.bag");
  reader.Number<uint8_t>();
  EXPECT_THAT(TextOfError([&] { reader.Number<uint32_t>(); }), HasSubstr("a.bag: byte 1"));
  const std::vector<uint8_t> odd = {9, 9, 9, 9};
  EXPECT_THAT(TextOfError([&] { WireReader(odd.data(), odd.size(), MessageEncoding::kCdr, "a"); }),
              HasSubstr("plain CDR"));
}

TEST(WireReader, SequencesLongerThanTheMessageAreErrorsAtOnce) {
  const std::vector<uint8_t> bytes = BytesBuilder().Add<uint32_t>(4'000'000'000U).bytes();
  WireReader reader(bytes.data(), bytes.size(), MessageEncoding::kRos1, "a.bag");
  EXPECT_THAT(TextOfError([&] { reader.Count(1); }), HasSubstr("4000000000 elements"));
}

}  // namespace
}  // namespace tvl
