#include "tvl/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <ostream>
#include <sstream>

namespace tvl {
namespace {

constexpr double kRedraw_ms = 100.0;     // on a terminal
constexpr double kPlainLine_ms = 10000;  // elsewhere
constexpr size_t kBarWidth = 24;

}  // namespace

Progress::Progress(std::ostream& out, bool is_terminal, std::string unit, size_t total)
    : out_(out), is_terminal_(is_terminal), unit_(std::move(unit)), total_(total) {}

Progress::~Progress() {
  if (is_terminal_ && printed_) out_ << "\n" << std::flush;
}

void Progress::Update(size_t done, const std::string& stage) {
  const bool last = total_ > 0 && done >= total_;
  const double pause_ms = is_terminal_ ? kRedraw_ms : kPlainLine_ms;
  if (printed_ && !last && since_print_.ElapsedMs() < pause_ms) return;
  if (!printed_ && !is_terminal_ && !last && since_start_.ElapsedMs() < kPlainLine_ms) return;
  since_print_.LapMs();
  printed_ = true;
  if (is_terminal_) {
    out_ << "\r\033[K" << Line(done, stage) << std::flush;
  } else {
    out_ << Line(done, stage) << "\n" << std::flush;
  }
}

std::string Progress::Line(size_t done, const std::string& stage) const {
  const double elapsed_s = std::max(1e-3, 1e-3 * since_start_.ElapsedMs());
  const double rate = static_cast<double>(done) / elapsed_s;
  std::ostringstream line;
  if (total_ > 0 && is_terminal_) {
    const size_t filled = std::min(kBarWidth, done * kBarWidth / total_);
    line << "[" << std::string(filled, '#') << std::string(kBarWidth - filled, '.') << "] ";
  }
  line << done;
  if (total_ > 0) line << "/" << total_;
  line << " " << unit_ << std::fixed << std::setprecision(1) << "  " << rate << " " << unit_
       << "/s";
  if (total_ > 0 && rate > 0.0) {
    const int left_s =
        static_cast<int>(std::lround(static_cast<double>(total_ - std::min(done, total_)) / rate));
    line << "  ETA " << left_s / 60 << ":" << std::setw(2) << std::setfill('0') << left_s % 60;
  }
  if (!stage.empty()) line << "  " << stage;
  return line.str();
}

bool StderrIsTerminal() { return isatty(STDERR_FILENO) != 0; }

}  // namespace tvl
