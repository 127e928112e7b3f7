#include "tvl/cli/version.h"

namespace tvl {

std::string Version() { return TVL_VERSION; }

}  // namespace tvl
