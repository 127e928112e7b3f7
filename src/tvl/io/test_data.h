// For tests: the recordings named by the environment variable TVL_TEST_DATA.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>

namespace tvl {

// TVL_TEST_DATA/relative, or empty if the variable is not set: the test is then skipped. A file
// that is missing although the variable is set must fail the test, so it is not looked for here.
inline std::optional<std::string> TestDataPath(const std::string& relative) {
  const char* root = std::getenv("TVL_TEST_DATA");
  if (root == nullptr || *root == '\0') return std::nullopt;
  return std::string(root) + "/" + relative;
}

}  // namespace tvl
