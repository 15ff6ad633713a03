#include <algorithm>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies that a thread takes at once: about a megabyte of columns.
constexpr uint64_t kGrain = 8192;

/** Semi-implicit Euler: v' = v + (F/m) dt, then x' = x + v' dt. */
template <class Real>
struct NewtonMotion {
  static constexpr auto kName = "newton_motion", kVersion = "1.0.0";
  static constexpr auto kDoc = "Newton's second law by semi-implicit Euler; mass 0 is immovable.";
  static constexpr auto kPhase = Phase::kIntegrate;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> force{"externalForce", "body", units::newton};
  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  ReadWrite<Vec3<Real>> position{"position", "body", units::metre};
  OptionalWrite<Vec3<Real>> acceleration{"acceleration", "body", units::metre_per_second_squared};

  auto Properties() { return std::tie(mass, force, velocity, position, acceleration); }

  void Advance(const Step& step) {
    if (step.stage == 0) {  // no forces yet, so nothing moves; but WRITE means written, always
      std::fill(acceleration.begin(), acceleration.end(), Vec3<Real>{});
      return;
    }
    const auto dt = static_cast<Real>(step.dt);
    step.ParallelFor(mass.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      if (acceleration.present()) Accelerate(begin, end);
      Move(begin, end, dt);
    });
  }

  void Accelerate(uint64_t begin, uint64_t end) const {
    for (uint64_t i = begin; i < end; ++i) {
      acceleration[i] = mass[i] == 0 ? Vec3<Real>{} : force[i] * (1 / mass[i]);
    }
  }

  void Move(uint64_t begin, uint64_t end, Real dt) const {
    for (uint64_t i = begin; i < end; ++i) {
      if (mass[i] == 0) continue;
      velocity[i] += force[i] * (1 / mass[i]) * dt;
      position[i] += velocity[i] * dt;
    }
  }
};

}  // namespace

VESPER_LAW_LIBRARY("newton_motion", NewtonMotion)
