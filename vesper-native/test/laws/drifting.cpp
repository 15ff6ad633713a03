// SPDX-License-Identifier: Apache-2.0
// Reads fields through law.hpp, one position at a time: a vector and an optional number.
#include "vesper/law.hpp"

namespace {

using namespace vesper;

template <class Real>
struct Drifting {
  static constexpr auto kName = "drifting", kVersion = "1.0.0";
  static constexpr auto kDoc = "Gives every body the speed of the wind, if it is warm.";
  static constexpr auto kPhase = Phase::kConstrain;

  Field<Vec3<Real>> wind{"wind", "world", units::metre_per_second};
  OptionalField<Real> temperature{"temperature", "world", units::kelvin};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  auto Properties() { return std::tie(wind, temperature, position, velocity); }

  void Advance(const Step&) {
    for (uint64_t i = 0; i < position.size(); ++i) {
      if (temperature.present() && temperature(position[i]) < Real(273.15)) continue;
      velocity[i] = wind(position[i]);
    }
  }
};

}  // namespace

VESPER_LAW_LIBRARY("drifting", Drifting)
