// SPDX-License-Identifier: Apache-2.0
// An integrator whose clock is fast by a tenth: its error does not vanish with dt. With MOVES_ALL
// it also moves bodies of mass 0.
#include "vesper/law.hpp"

namespace {

using namespace vesper;

template <class Real>
struct BrokenMotion {
  static constexpr auto kName = "broken_motion", kVersion = "1.0.0";
  static constexpr auto kDoc = "Takes steps that are too long.";
  static constexpr auto kPhase = Phase::kIntegrate;

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> force{"externalForce", "body", units::newton};
  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  ReadWrite<Vec3<Real>> position{"position", "body", units::metre};

  auto Properties() { return std::tie(mass, force, velocity, position); }

  void Advance(const Step& step) {
    if (step.stage == 0) return;
    const auto dt = static_cast<Real>(1.1 * step.dt);
    for (uint64_t i = 0; i < position.size(); ++i) {
      if (mass[i] == 0 && !MOVES_ALL) continue;
      if (mass[i] != 0) velocity[i] += force[i] * (dt / mass[i]);
      position[i] += velocity[i] * dt;
    }
  }
};

}  // namespace

VESPER_LAW_LIBRARY("broken_motion", BrokenMotion)
