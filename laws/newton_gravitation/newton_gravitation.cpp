// SPDX-License-Identifier: Apache-2.0
#include "all_pairs/all_pairs.hpp"

namespace {

using namespace vesper;

/** Newton's law of gravitation between all pairs of bodies, with Plummer softening. */
template <class Real>
struct NewtonGravitation {
  static constexpr auto kName = "newton_gravitation", kVersion = "1.0.0";
  static constexpr auto kDoc = "Newtonian gravitation between all pairs of bodies, softened.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims =
      kMomentum | kAngularMomentum | kTranslation | kRotation | kEnergy;

  Parameter fast{
      "fast",     "Above 0: roots from the processor's approximation; bits differ with it.",
      units::one, 0,
      0,          1};
  Read<Real> gravitational_constant{"gravitationalConstant", "world",
                                    units::gravitational_constant};
  OptionalRead<Real> softening{"softening", "world", units::metre};
  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Parameters() { return std::tie(fast); }
  auto Properties() { return std::tie(gravitational_constant, softening, mass, position, force); }

  void Bind() { pairs_.Resize(mass.size()); }

  void Advance(const Step& step) {
    if (gravitational_constant.size() == 0) return;  // the kind `world` has no row
    const auto root = fast.value() > 0 ? ReciprocalRoot::kApproximate : ReciprocalRoot::kPortable;
    pairs_.Attract(step, root, double{gravitational_constant[0]}, Softening(), mass, position,
                   force);
  }

  /** Returns the sum of -G m m' / sqrt(r^2 + softening^2) over the pairs. */
  double PotentialEnergy() const {
    if (gravitational_constant.size() == 0) return 0;
    return -double{gravitational_constant[0]} * pairs_.SumOfPotentials(Softening(), mass, position);
  }

 private:
  double Softening() const { return softening.size() == 0 ? 0 : double{softening[0]}; }

  AllPairs<Real> pairs_;
};

}  // namespace

VESPER_LAW_LIBRARY("newton_gravitation", NewtonGravitation)
