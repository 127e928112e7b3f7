// Which tvl this is.
#pragma once

#include <string>

namespace tvl {

std::string Version();

}  // namespace tvl
