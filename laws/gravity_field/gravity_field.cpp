// SPDX-License-Identifier: Apache-2.0
#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies per chunk of a thread; a chunk's columns fill about half a megabyte.
constexpr uint64_t kGrain = 16384;

/** A uniform gravitational field: F = m g. */
template <class Real>
struct GravityField {
  static constexpr auto kName = "gravity_field", kVersion = "1.0.0";
  static constexpr auto kDoc = "Weight in the world's uniform gravity, F = m g.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kTranslation | kRotation | kEnergy;

  Read<Vec3<Real>> gravity{"gravity", "world", units::metre_per_second_squared};
  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() { return std::tie(gravity, mass, position, force); }

  void Advance(const Step& step) {
    if (gravity.size() == 0) return;  // the kind `world` has no row: no field
    const Vec3<Real> g = gravity[0];
    step.ParallelFor(mass.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) force[i] += mass[i] * g;
    });
  }

  /** Returns minus the sum of m g.x. The potential energy is zero at the origin. */
  double PotentialEnergy() const {
    if (gravity.size() == 0) return 0;
    double energy = 0;
    for (uint64_t i = 0; i < mass.size(); ++i) {
      energy -= double{mass[i]} * double{Dot(gravity[0], position[i])};
    }
    return energy;
  }
};

}  // namespace

VESPER_LAW_LIBRARY("gravity_field", GravityField)
