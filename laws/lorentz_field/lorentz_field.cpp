// SPDX-License-Identifier: Apache-2.0
#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies per chunk of a thread; a chunk's columns fill about half a megabyte.
constexpr uint64_t kGrain = 16384;

/** Force on charges in a uniform electric and a uniform magnetic field: F = q (E + v x B). */
template <class Real>
struct LorentzField {
  static constexpr auto kName = "lorentz_field", kVersion = "1.0.0";
  static constexpr auto kDoc = "Charges in the world's uniform fields, F = q (E + v x B).";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  OptionalRead<Vec3<Real>> electric{"electricField", "world", units::volt_per_metre};
  OptionalRead<Vec3<Real>> magnetic{"magneticField", "world", units::tesla};
  Read<Real> charge{"charge", "body", units::coulomb};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() { return std::tie(electric, magnetic, charge, position, velocity, force); }

  void Advance(const Step& step) {
    const Vec3<Real> e = OfTheWorld(electric), b = OfTheWorld(magnetic);
    step.ParallelFor(charge.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) force[i] += charge[i] * (e + Cross(velocity[i], b));
    });
  }

  /** Returns minus the sum of q E.x. The potential energy is zero at the origin. The magnetic
   *  field does no work. */
  double PotentialEnergy() const {
    const Vec3<Real> e = OfTheWorld(electric);
    double energy = 0;
    for (uint64_t i = 0; i < charge.size(); ++i) {
      energy -= double{charge[i]} * double{Dot(e, position[i])};
    }
    return energy;
  }

  /** Returns the field; zero if the world lacks the property, or the kind `world` has no row. */
  static Vec3<Real> OfTheWorld(const OptionalRead<Vec3<Real>>& field) {
    return field.size() == 0 ? Vec3<Real>{} : field[0];
  }
};

}  // namespace

VESPER_LAW_LIBRARY("lorentz_field", LorentzField)
