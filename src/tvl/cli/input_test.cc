#include "tvl/cli/input.h"

#include <gtest/gtest.h>

#include "tvl/base/check.h"

namespace tvl {
namespace {

TEST(OpenInput, NamesWhatIsWrong) {
  try {
    OpenInput("no/such/folder");
    FAIL() << "no error";
  } catch (const InputError& e) {
    EXPECT_EQ(std::string(e.what()), "no/such/folder: no such folder");
  }
  EXPECT_THROW(OpenInput("sim:no such preset"), InputError);
  EXPECT_THROW(OpenInput(".", {"no such profile"}), InputError);
}

}  // namespace
}  // namespace tvl
