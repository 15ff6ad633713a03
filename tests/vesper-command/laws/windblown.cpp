// SPDX-License-Identifier: Apache-2.0
// Reads a field of the prototype and one that nobody but the law knows: at each body's place or,
// to break its claim that the origin does not matter, always at one.
#include "vesper/law.hpp"

namespace {

using namespace vesper;

template <class Real>
struct Windblown {
  static constexpr auto kName = "windblown", kVersion = "1.0.0";
  static constexpr auto kDoc = "Force of a field, less where the air is thin.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  Field<Vec3<Real>> field{"forceField", "world", units::newton};
  OptionalField<Real> density{"airDensity", "world", units::one};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
  auto Properties() { return std::tie(field, density, position, force); }

  void Advance(const Step&) {
    for (uint64_t i = 0; i < position.size(); ++i) {
      const Vec3<Real> at = FIXED_PLACE ? Vec3<Real>{1, 2, 3} : position[i];
      force[i] += field(at) * (density.present() ? density(at) : Real(1));
    }
  }
};

}  // namespace

VESPER_LAW_LIBRARY(LIBRARY_NAME, Windblown)
