#include "tvl/cli/interrupt.h"

#include <csignal>

namespace tvl {
namespace {

// The one global of the program: a signal handler can reach nothing else.
// NOLINTNEXTLINE(cppcoreguidelines-avoid-non-const-global-variables)
volatile std::sig_atomic_t g_interrupted = 0;

void Handle(int signal) {
  g_interrupted = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void CatchInterrupts() {
  std::signal(SIGINT, Handle);
  std::signal(SIGTERM, Handle);
}

bool Interrupted() { return g_interrupted != 0; }

}  // namespace tvl
