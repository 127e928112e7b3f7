// One line that tells how far a long job is: redrawn on a terminal, now and then elsewhere.
#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>

#include "tvl/base/stopwatch.h"

namespace tvl {

class Progress {
 public:
  // `total` items, 0 if not known. `is_terminal` chooses between a bar and plain lines.
  Progress(std::ostream& out, bool is_terminal, std::string unit, size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // `done` items are finished; `stage` is a word or two on what is going on.
  void Update(size_t done, const std::string& stage);

 private:
  std::string Line(size_t done, const std::string& stage) const;

  std::ostream& out_;
  bool is_terminal_;
  std::string unit_;
  size_t total_;
  Stopwatch since_start_, since_print_;
  bool printed_ = false;
};

// Whether standard error is a terminal.
bool StderrIsTerminal();

}  // namespace tvl
