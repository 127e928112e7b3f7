// Ctrl-C and SIGTERM as a question a loop can ask.
#pragma once

namespace tvl {

// From now on the first SIGINT or SIGTERM only makes Interrupted() true; a second one kills.
void CatchInterrupts();
bool Interrupted();  // from any thread

}  // namespace tvl
