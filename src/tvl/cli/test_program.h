// Runs TVL_BINARY in a test, in a folder that is gone afterwards.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "tvl/io/temp_folder.h"

namespace tvl {

struct Outcome {
  int exit_code;
  std::string out, err;
};

class Program : public testing::Test {
 protected:
  static std::string Text(const std::string& path) {
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  Outcome Run(const std::string& arguments) const {
    const std::string out = folder_ / "stdout", err = folder_ / "stderr";
    const std::string command =
        std::string(TVL_BINARY) + " " + arguments + " > " + out + " 2> " + err + " < /dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, Text(out), Text(err)};
  }

  TempFolder folder_;
};

}  // namespace tvl
