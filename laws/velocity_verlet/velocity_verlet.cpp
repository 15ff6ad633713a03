// SPDX-License-Identifier: Apache-2.0
#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies per chunk of a thread; a chunk's columns fill about a megabyte.
constexpr uint64_t kGrain = 8192;

/** The velocity Verlet method: v += a/2 dt; x += v dt; compute the new a; v += a/2 dt. */
template <class Real>
struct VelocityVerlet {
  static constexpr auto kName = "velocity_verlet", kVersion = "1.0.0";
  static constexpr auto kDoc = "Newton's second law by velocity Verlet; mass 0 is immovable.";
  static constexpr auto kPhase = Phase::kIntegrate;
  static constexpr uint32_t kClaims = kTranslation | kRotation;
  static constexpr std::array<double, 2> kForceWeights = {0.5, 0.5};

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> force{"externalForce", "body", units::newton};
  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  ReadWrite<Vec3<Real>> position{"position", "body", units::metre};
  Scratch<Vec3<Real>> last{"lastAcceleration", "body", units::metre_per_second_squared};
  Scratch<uint32_t> known{"lastAccelerationKnown", "body", units::one};

  auto Properties() { return std::tie(mass, force, velocity, position, last, known); }

  void Advance(const Step& step) {
    const auto dt = static_cast<Real>(step.dt);
    step.ParallelFor(mass.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        if (mass[i] == 0) {
          last[i] = {};
          known[i] = 0;
        } else if (step.stage == 0) {
          KickAndDrift(i, dt);
        } else {
          Kick(i, dt);
        }
      }
    });
  }

  void KickAndDrift(uint64_t i, Real dt) const {
    velocity[i] += last[i] * (dt / 2);
    position[i] += velocity[i] * dt;
  }

  void Kick(uint64_t i, Real dt) const {
    const Vec3<Real> a = force[i] * (1 / mass[i]);
    if (known[i] != 0) {
      velocity[i] += a * (dt / 2);
    } else {  // the body's first step: adds both changes of velocity at once, and the change of
              // position that the first of them causes
      velocity[i] += a * dt;
      position[i] += a * (dt * dt / 2);
    }
    last[i] = a;
    known[i] = 1;
  }
};

}  // namespace

VESPER_LAW_LIBRARY("velocity_verlet", VelocityVerlet)
