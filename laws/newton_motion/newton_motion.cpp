#include <algorithm>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies that a thread takes at once: enough to be worth waking it.
constexpr uint64_t kGrain = 4096;
// Bodies whose masses are looked at before they move.
constexpr uint64_t kBlock = 64;

/** Semi-implicit Euler: v' = v + (F/m) dt, then x' = x + v' dt. */
template <class Real>
struct NewtonMotion {
  static constexpr auto kName = "newton_motion", kVersion = "1.0.0";
  static constexpr auto kDoc = "Newton's second law by semi-implicit Euler; mass 0 is immovable.";
  static constexpr auto kPhase = Phase::kIntegrate;
  static constexpr uint32_t kFirstStage = 1;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> force{"externalForce", "body", units::newton};
  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  ReadWrite<Vec3<Real>> position{"position", "body", units::metre};
  OptionalWrite<Vec3<Real>> acceleration{"acceleration", "body", units::metre_per_second_squared};

  auto Properties() { return std::tie(mass, force, velocity, position, acceleration); }

  void Advance(const Step& step) {
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
    for (; end - begin >= kBlock; begin += kBlock) {
      uint32_t immovable = 0;
      for (uint64_t i = begin; i < begin + kBlock; ++i) immovable += mass[i] == 0;
      if (immovable == 0) {
        MoveBlock(begin, dt);
      } else {
        MoveEach(begin, begin + kBlock, dt);
      }
    }
    MoveEach(begin, end, dt);
  }

  void MoveEach(uint64_t begin, uint64_t end, Real dt) const {
    for (uint64_t i = begin; i < end; ++i) {
      if (mass[i] == 0) continue;
      velocity[i] += force[i] * (1 / mass[i]) * dt;
      position[i] += velocity[i] * dt;
    }
  }

  /** The same for a block in which no mass is 0, component by component, for the compiler to work on
   *  several of them at once. */
  void MoveBlock(uint64_t begin, Real dt) const {
    Real inverse[3 * kBlock];
    for (uint64_t i = 0; i < kBlock; ++i) {
      inverse[3 * i] = inverse[3 * i + 1] = inverse[3 * i + 2] = 1 / mass[begin + i];
    }
    const Real* __restrict f = &force[begin].x;
    Real *__restrict v = &velocity[begin].x, *__restrict x = &position[begin].x;
    for (uint64_t j = 0; j < 3 * kBlock; ++j) {
      v[j] += f[j] * inverse[j] * dt;
      x[j] += v[j] * dt;
    }
  }
};

}  // namespace

VESPER_LAW_LIBRARY("newton_motion", NewtonMotion)
