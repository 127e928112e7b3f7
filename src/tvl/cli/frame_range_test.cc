#include "tvl/cli/frame_range.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl {
namespace {

TEST(FrameRange, PartsMayBeEmptyAndTheEndIsCut) {
  EXPECT_EQ(ParseFrameRange("", 10).end, 10u);
  EXPECT_EQ(ParseFrameRange("3:", 10).begin, 3u);
  EXPECT_EQ(ParseFrameRange(":4", 10).end, 4u);
  EXPECT_EQ(ParseFrameRange("2:99", 10).end, 10u);
  EXPECT_EQ(FirstFrame("7:9"), 7u);
  EXPECT_EQ(FirstFrame(""), 0u);
}

TEST(FrameRange, RefusesNonsense) {
  for (const char* text : {"5", "a:b", "5:5", "12:20", "-1:3", "1:2:3"}) {
    EXPECT_THROW(ParseFrameRange(text, 10), InputError) << text;
  }
}

}  // namespace
}  // namespace tvl
