// For tests: files as bytes in memory.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

#include "tvl/base/check.h"

namespace tvl {

// The bytes of a number as this (little-endian) platform has it in memory.
template <typename T>
std::string Bytes(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

template <typename T, typename... More>
std::string Bytes(T value, More... more) {
  return Bytes(value) + Bytes(more...);
}

// Big endian.
template <typename T>
std::string BigBytes(T value) {
  const std::string bytes = Bytes(value);
  return {bytes.rbegin(), bytes.rend()};
}

inline const uint8_t* DataOf(const std::string& bytes) {
  return reinterpret_cast<const uint8_t*>(bytes.data());
}

// The text of the InputError that `call` throws; empty if it throws none.
template <typename Call>
std::string InputErrorOf(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace tvl
