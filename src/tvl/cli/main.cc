// The program `tvl`: tightly coupled camera + lidar SLAM, one file a command.
//
// Exit codes: 0 all well; 1 something failed (a defect, or the machine); 2 the input or the command
// line is unusable. Messages go to stderr.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "tvl/base/check.h"
#include "tvl/cli/commands.h"
#include "tvl/cli/version.h"

namespace tvl {
namespace {

constexpr int kFailed = 1;
constexpr int kUnusableInput = 2;

void AddCommands(CLI::App& app) {
  AddRunCommand(app);
#ifdef TVL_WITH_SIM
  AddSimulateCommand(app);
#endif
  AddCalibrateCommand(app);
  AddEvaluateCommand(app);
  AddInspectCommand(app);
  AddShowCommand(app);
  AddVocabularyCommand(app);
}

int Main(int argc, char** argv) {
  CLI::App app("tvl: tightly coupled monocular camera + 3D lidar SLAM", "tvl");
  app.set_version_flag("--version", Version());
  app.require_subcommand(1);
  AddCommands(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::RuntimeError& e) {
    return e.get_exit_code();
  } catch (const CLI::ParseError& e) {  // also --help and --version, with code 0
    return app.exit(e) == 0 ? 0 : kUnusableInput;
  } catch (const InputError& e) {
    std::cerr << "tvl: " << e.what() << "\n";
    return kUnusableInput;
  } catch (const std::exception& e) {
    std::cerr << "tvl: failed: " << e.what() << "\n";
    return kFailed;
  }
  return 0;
}

}  // namespace
}  // namespace tvl

int main(int argc, char** argv) { return tvl::Main(argc, argv); }
