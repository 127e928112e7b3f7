#include "tvl/cli/progress.h"

#include <gtest/gtest.h>

#include <sstream>

namespace tvl {
namespace {

TEST(Progress, TerminalGetsOneLineThatIsRedrawn) {
  std::ostringstream out;
  {
    Progress progress(out, true, "frames", 10);
    progress.Update(5, "map step");
    progress.Update(10, "map step");
  }
  EXPECT_NE(out.str().find("[############............] 5/10 frames"), std::string::npos);
  EXPECT_NE(out.str().find("10/10 frames"), std::string::npos);
  EXPECT_EQ(out.str().back(), '\n');
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1);
}

TEST(Progress, FilesGetPlainLinesOnly) {
  std::ostringstream out;
  Progress progress(out, false, "frames", 3);
  progress.Update(1, "");  // too early for a line
  EXPECT_TRUE(out.str().empty());
  progress.Update(3, "");
  EXPECT_EQ(out.str().find('\r'), std::string::npos);
  EXPECT_EQ(out.str().rfind("3/3 frames", 0), 0u);
}

}  // namespace
}  // namespace tvl
