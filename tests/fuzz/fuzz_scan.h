// What every fuzzer of a scan reader checks: bad bytes throw InputError that names the source, and
// good ones give a scan that does not contradict itself. Anything else ends the run.
#pragma once

#include <cstdlib>
#include <string>

#include "tvl/base/check.h"
#include "tvl/sensor/raw_scan.h"

namespace tvl {

inline void Require(bool condition) {
  if (!condition) __builtin_trap();
}

inline void RequireConsistent(const RawScan& scan) {
  const auto fits = [&](size_t size) { return size == 0 || size == scan.size(); };
  Require(fits(scan.intensity.size()) && fits(scan.ring.size()) && fits(scan.time.size()));
  Require(scan.width * scan.height == scan.size());
}

// `parse` takes the name of the source.
template <typename Parse>
void FuzzScan(const Parse& parse) {
  const std::string source = "fuzz";
  try {
    RequireConsistent(parse(source));
  } catch (const InputError& error) {
    Require(std::string(error.what()).compare(0, source.size(), source) == 0);
  }
}

}  // namespace tvl
