// SPDX-License-Identifier: Apache-2.0
#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies per chunk of a thread; a chunk's columns fill about a megabyte.
constexpr uint64_t kGrain = 4096;

/** The classical fourth-order Runge-Kutta method for x' = v, v' = F(x, v) / m. */
template <class Real>
struct RungeKutta4 {
  static constexpr auto kName = "runge_kutta4", kVersion = "1.0.0";
  static constexpr auto kDoc = "Newton's second law by Runge-Kutta 4; mass 0 is immovable.";
  static constexpr auto kPhase = Phase::kIntegrate;
  static constexpr uint32_t kStages = 4;
  static constexpr std::array<double, 5> kForceWeights = {0, 1. / 6, 1. / 3, 1. / 3, 1. / 6};
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  Read<Real> mass{"mass", "body", units::kilogram};
  Read<Vec3<Real>> force{"externalForce", "body", units::newton};
  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  ReadWrite<Vec3<Real>> position{"position", "body", units::metre};
  // The state at the start of the step, and the weighted sums of the slopes of its stages so far.
  Scratch<Vec3<Real>> x0{"startPosition", "body", units::metre};
  Scratch<Vec3<Real>> v0{"startVelocity", "body", units::metre_per_second};
  Scratch<Vec3<Real>> dx{"slopeOfPosition", "body", units::metre_per_second};
  Scratch<Vec3<Real>> dv{"slopeOfVelocity", "body", units::metre_per_second_squared};

  auto Properties() { return std::tie(mass, force, velocity, position, x0, v0, dx, dv); }

  void Advance(const Step& step) {
    step.ParallelFor(mass.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        if (mass[i] == 0) continue;
        if (step.stage == 0) {
          Begin(i);
        } else {
          Evaluate(i, step.stage, static_cast<Real>(step.dt));
        }
      }
    });
  }

  void Begin(uint64_t i) const {
    x0[i] = position[i];
    v0[i] = velocity[i];
    dx[i] = dv[i] = {};
  }

  /** Adds the slope of the present stage, and moves the body to the state at which the next stage
   *  is evaluated. */
  void Evaluate(uint64_t i, uint32_t stage, Real dt) const {
    const Vec3<Real> slope_x = velocity[i];
    const Vec3<Real> slope_v = force[i] * (1 / mass[i]);
    const Real weight = stage == 1 || stage == 4 ? Real{1} / 6 : Real{1} / 3;
    dx[i] += slope_x * weight;
    dv[i] += slope_v * weight;
    if (stage == 4) {
      position[i] = x0[i] + dx[i] * dt;
      velocity[i] = v0[i] + dv[i] * dt;
      return;
    }
    const Real ahead = stage == 3 ? dt : dt / 2;
    position[i] = x0[i] + slope_x * ahead;
    velocity[i] = v0[i] + slope_v * ahead;
  }
};

}  // namespace

VESPER_LAW_LIBRARY("runge_kutta4", RungeKutta4)
