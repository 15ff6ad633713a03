// SPDX-License-Identifier: Apache-2.0
// The dimensions of quantities in a law text. All values are in SI units.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "vesper/types.h"

namespace vesper::text {

/// Exponents of m, kg, s, A, K, mol and cd, in twelfths. With twelfths, the results of roots also
/// have dimensions.
struct Dimension {
  static constexpr int kWhole = 12;
  static constexpr int kMost = 100 * kWhole;

  std::array<int, 7> twelfths{};

  bool operator==(const Dimension&) const = default;
  bool IsOne() const { return *this == Dimension{}; }
  /// Returns true if all exponents are whole numbers, as in units of the engine.
  bool IsWhole() const;
  /// Returns true if the exponents are within the limits of the engine's units.
  bool IsPossible() const;
};

Dimension DimensionOf(const vesper_unit& unit);
Dimension operator*(const Dimension& a, const Dimension& b);
Dimension operator/(const Dimension& a, const Dimension& b);
/// Returns the dimension to the power of `twelfths` / 12. Sets `exact` to false if an exponent of
/// the result is no multiple of a twelfth.
Dimension Power(const Dimension& base, int twelfths, bool& exact);

/// Returns the SI unit: "N", "kg/s", "1".
std::string UnitName(const Dimension& dimension);
/// Returns unit and quantity: "N (a force)", "a plain number".
std::string Describe(const Dimension& dimension);
/// Returns the unit for the tables of a law; IsWhole must be true.
vesper_unit ToUnit(const Dimension& dimension);

inline constexpr Dimension Metres(int m, int kg, int s, int a = 0, int k = 0) {
  return {{m * 12, kg * 12, s * 12, a * 12, k * 12, 0, 0}};
}
inline constexpr Dimension kNumber{};
inline constexpr Dimension kLength = Metres(1, 0, 0);
inline constexpr Dimension kTime = Metres(0, 0, 1);
inline constexpr Dimension kForce = Metres(1, 1, -2);
inline constexpr Dimension kEnergy = Metres(2, 1, -2);

}  // namespace vesper::text
