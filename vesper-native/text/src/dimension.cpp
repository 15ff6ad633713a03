// SPDX-License-Identifier: Apache-2.0
#include "dimension.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>

namespace vesper::text {
namespace {

struct Known {
  Dimension dimension;
  const char* unit;
  const char* quantity;
};

// Names of units and quantities, for messages. If several entries have the same dimension, the
// first one is used.
constexpr Known kKnown[] = {
    {Metres(1, 0, 0), "m", "a length"},
    {Metres(0, 1, 0), "kg", "a mass"},
    {Metres(0, 0, 1), "s", "a time"},
    {Metres(0, 0, 0, 1), "A", "an electric current"},
    {Metres(0, 0, 0, 0, 1), "K", "a temperature"},
    {Metres(2, 0, 0), "m^2", "an area"},
    {Metres(3, 0, 0), "m^3", "a volume"},
    {Metres(1, 0, -1), "m/s", "a velocity"},
    {Metres(1, 0, -2), "m/s^2", "an acceleration"},
    {Metres(0, 0, -1), "1/s", "a rate"},
    {Metres(0, 0, -2), "1/s^2", "an angular acceleration"},
    {Metres(1, 1, -1), "kg*m/s", "a momentum"},
    {Metres(2, 1, -1), "kg*m^2/s", "an angular momentum"},
    {Metres(1, 1, -2), "N", "a force"},
    {Metres(2, 1, -2), "J", "an energy or a torque"},
    {Metres(2, 1, -3), "W", "a power"},
    {Metres(-1, 1, -2), "Pa", "a pressure"},
    {Metres(-3, 1, 0), "kg/m^3", "a density"},
    {Metres(-1, 1, 0), "kg/m", "a coefficient of quadratic drag"},
    {Metres(0, 1, -1), "kg/s", "a coefficient of linear drag"},
    {Metres(0, 1, -2), "N/m", "a stiffness"},
    {Metres(2, 1, 0), "kg*m^2", "a moment of inertia"},
    {Metres(-1, 1, -1), "Pa*s", "a viscosity"},
    {Metres(0, 0, 1, 1), "C", "an electric charge"},
    {Metres(2, 1, -3, -1), "V", "a voltage"},
    {Metres(1, 1, -3, -1), "V/m", "an electric field"},
    {Metres(0, 1, -2, -1), "T", "a magnetic field"},
    {Metres(3, -1, -2), "N*m^2/kg^2", "a gravitational constant"},
    {Metres(3, 1, -4, -2), "N*m^2/C^2", "a Coulomb constant"},
    {Metres(2, 1, -2, 0, -1), "J/K", "a heat capacity"},
    {Metres(2, 1, -3, 0, -1), "W/K", "a thermal conductance"},
    {Metres(1, 1, -3, 0, -1), "W/(m*K)", "a thermal conductivity"},
    {Metres(2, 0, -2, 0, -1), "J/(kg*K)", "a specific heat"},
    {Metres(2, 0, -1), "m^2/s", "a diffusivity"},
    {Metres(2, 0, -2), "m^2/s^2", "a squared velocity"},
    {Metres(-1, 0, 0), "1/m", "an inverse length"},
};

const Known* Find(const Dimension& dimension) {
  const auto* found = std::find_if(std::begin(kKnown), std::end(kKnown), [&](const Known& known) {
    return known.dimension == dimension;
  });
  return found == std::end(kKnown) ? nullptr : found;
}

void AppendFactor(std::string& to, const char* symbol, int twelfths) {
  if (!to.empty()) to += '*';
  to += symbol;
  if (twelfths == Dimension::kWhole) return;
  if (twelfths % Dimension::kWhole == 0) {
    to += '^' + std::to_string(twelfths / Dimension::kWhole);
    return;
  }
  int numerator = twelfths, denominator = Dimension::kWhole;
  for (const int factor : {2, 2, 3}) {
    if (numerator % factor != 0 || denominator % factor != 0) continue;
    numerator /= factor;
    denominator /= factor;
  }
  to += "^(" + std::to_string(numerator) + '/' + std::to_string(denominator) + ')';
}

}  // namespace

bool Dimension::IsWhole() const {
  return std::all_of(twelfths.begin(), twelfths.end(), [](int e) { return e % kWhole == 0; });
}

bool Dimension::IsPossible() const {
  return std::all_of(twelfths.begin(), twelfths.end(), [](int e) { return std::abs(e) <= kMost; });
}

Dimension DimensionOf(const vesper_unit& unit) {
  Dimension dimension;
  for (size_t i = 0; i < dimension.twelfths.size(); ++i) {
    dimension.twelfths[i] = unit.exponent[i] * Dimension::kWhole;
  }
  return dimension;
}

Dimension operator*(const Dimension& a, const Dimension& b) {
  Dimension product;
  for (size_t i = 0; i < a.twelfths.size(); ++i) {
    product.twelfths[i] = a.twelfths[i] + b.twelfths[i];
  }
  return product;
}

Dimension operator/(const Dimension& a, const Dimension& b) {
  Dimension quotient;
  for (size_t i = 0; i < a.twelfths.size(); ++i) {
    quotient.twelfths[i] = a.twelfths[i] - b.twelfths[i];
  }
  return quotient;
}

Dimension Power(const Dimension& base, int twelfths, bool& exact) {
  Dimension power;
  exact = true;
  for (size_t i = 0; i < base.twelfths.size(); ++i) {
    const int64_t product = int64_t{base.twelfths[i]} * twelfths;
    exact = exact && product % Dimension::kWhole == 0;
    const int64_t limit = Dimension::kMost + Dimension::kWhole;
    power.twelfths[i] =
        static_cast<int>(std::clamp<int64_t>(product / Dimension::kWhole, -limit, limit));
  }
  return power;
}

std::string UnitName(const Dimension& dimension) {
  static constexpr const char* kBase[] = {"m", "kg", "s", "A", "K", "mol", "cd"};
  if (dimension.IsOne()) return "1";
  if (const Known* known = Find(dimension)) return known->unit;
  std::string over, under;
  int factors_under = 0;
  for (const size_t i : {1u, 0u, 3u, 4u, 5u, 6u, 2u}) {
    const int exponent = dimension.twelfths[i];
    if (exponent > 0) AppendFactor(over, kBase[i], exponent);
    if (exponent < 0) {
      AppendFactor(under, kBase[i], -exponent);
      ++factors_under;
    }
  }
  if (under.empty()) return over;
  if (over.empty()) over = "1";
  return over + '/' + (factors_under > 1 ? '(' + under + ')' : under);
}

std::string Describe(const Dimension& dimension) {
  if (dimension.IsOne()) return "a plain number";
  const Known* known = Find(dimension);
  return UnitName(dimension) +
         (known == nullptr ? std::string() : std::string(" (") + known->quantity + ')');
}

vesper_unit ToUnit(const Dimension& dimension) {
  vesper_unit unit{};
  for (size_t i = 0; i < dimension.twelfths.size(); ++i) {
    unit.exponent[i] = static_cast<int8_t>(dimension.twelfths[i] / Dimension::kWhole);
  }
  unit.scale = 1;
  const std::string name = UnitName(dimension);
  if (name.size() < sizeof unit.symbol) name.copy(unit.symbol, name.size());
  return unit;
}

}  // namespace vesper::text
