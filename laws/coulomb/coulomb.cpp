// SPDX-License-Identifier: Apache-2.0
#include "all_pairs/all_pairs.hpp"

namespace {

using namespace vesper;

/** Coulomb's law between all pairs of charges, with Plummer softening as in newton_gravitation. */
template <class Real>
struct Coulomb {
  static constexpr auto kName = "coulomb", kVersion = "1.0.0";
  static constexpr auto kDoc = "Electrostatic forces between all pairs of charges, softened.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims =
      kMomentum | kAngularMomentum | kTranslation | kRotation | kEnergy;

  Parameter fast{
      "fast",     "Above 0: roots from the processor's approximation; bits differ with it.",
      units::one, 0,
      0,          1};
  Read<Real> coulomb_constant{"coulombConstant", "world", units::coulomb_constant};
  OptionalRead<Real> softening{"softening", "world", units::metre};
  Read<Real> charge{"charge", "body", units::coulomb};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Parameters() { return std::tie(fast); }
  auto Properties() { return std::tie(coulomb_constant, softening, charge, position, force); }

  void Bind() { pairs_.Resize(charge.size()); }

  void Advance(const Step& step) {
    if (coulomb_constant.size() == 0) return;  // the kind `world` has no row
    const auto root = fast.value() > 0 ? ReciprocalRoot::kApproximate : ReciprocalRoot::kPortable;
    pairs_.Attract(step, root, -double{coulomb_constant[0]}, Softening(), charge, position, force);
  }

  /** Returns the sum of k q q' / sqrt(r^2 + softening^2) over the pairs. */
  double PotentialEnergy() const {
    if (coulomb_constant.size() == 0) return 0;
    return double{coulomb_constant[0]} * pairs_.SumOfPotentials(Softening(), charge, position);
  }

 private:
  double Softening() const { return softening.size() == 0 ? 0 : double{softening[0]}; }

  AllPairs<Real> pairs_;
};

}  // namespace

VESPER_LAW_LIBRARY("coulomb", Coulomb)
