#include "tvl/cli/interrupt.h"

#include <atomic>
#include <csignal>

namespace tvl {
namespace {

// The one global of the program: a signal handler can reach nothing else.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
std::atomic<bool> g_interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "signal handlers may not wait");

void Handle(int signal) {
  g_interrupted = true;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void CatchInterrupts() {
  std::signal(SIGINT, Handle);
  std::signal(SIGTERM, Handle);
}

bool Interrupted() { return g_interrupted; }

}  // namespace tvl
