// The subcommands of `tvl`. Each adds itself to the command line with its options; its callback
// does the work. A callback reports failure by throwing: InputError for bad input or options,
// CLI::RuntimeError(code) to end with that exit code without a message, anything else for a defect.
#pragma once

namespace CLI {
class App;
}

namespace tvl {

void AddCalibrateCommand(CLI::App& app);
void AddEvaluateCommand(CLI::App& app);
void AddInspectCommand(CLI::App& app);
void AddRunCommand(CLI::App& app);
void AddShowCommand(CLI::App& app);
void AddSimulateCommand(CLI::App& app);
void AddVocabularyCommand(CLI::App& app);

}  // namespace tvl
