// Conversions for the edges of the program (command line, YAML, reports); SI everywhere else.
#pragma once

namespace tvl {

inline constexpr double kPi = 3.14159265358979323846;

constexpr double DegToRad(double deg) { return deg * kPi / 180.0; }
constexpr double RadToDeg(double rad) { return rad * 180.0 / kPi; }

}  // namespace tvl
