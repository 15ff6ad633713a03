// SPDX-License-Identifier: Apache-2.0
#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Bodies per chunk of a thread; a chunk's columns fill about half a megabyte.
constexpr uint64_t kGrain = 16384;

/** Drag in a medium at rest, linear and quadratic in the speed: F = -(c1 + c2 |v|) v. */
template <class Real>
struct Drag {
  static constexpr auto kName = "drag", kVersion = "1.0.0";
  static constexpr auto kDoc =
      "Linear and quadratic drag in a medium at rest, F = -(c1 + c2 |v|) v.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  OptionalRead<Real> linear{"linearDragCoefficient", "body", units::kilogram_per_second};
  OptionalRead<Real> quadratic{"dragCoefficient", "body", units::kilogram_per_metre};
  Read<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() { return std::tie(linear, quadratic, velocity, force); }

  void Advance(const Step& step) {
    step.ParallelFor(velocity.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      if (linear.present()) {
        for (uint64_t i = begin; i < end; ++i) force[i] -= linear[i] * velocity[i];
      }
      if (quadratic.present()) {
        for (uint64_t i = begin; i < end; ++i) {
          force[i] -= quadratic[i] * Length(velocity[i]) * velocity[i];
        }
      }
    });
  }
};

}  // namespace

VESPER_LAW_LIBRARY("drag", Drag)
