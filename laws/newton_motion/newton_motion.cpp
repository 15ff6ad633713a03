// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "moves.hpp"
#include "vesper/law.hpp"

namespace {

using namespace vesper;
using newton_motion::AvailableMoves;
using newton_motion::Bodies;
using newton_motion::Moves;

// The constant kFew is the number of bodies up to which only one thread is used. The constant
// kGrain is the maximum number of bodies in a chunk of a thread. The size of chunks is a multiple
// of kVectors, so that only the last chunk has an incomplete vector.
constexpr uint64_t kFew = 2048, kGrain = 2048, kVectors = 64;
// Intended number of chunks. It is enough for all processors of a desktop computer.
constexpr uint64_t kChunks = 8;

uint64_t Grain(uint64_t bodies) {
  if (bodies <= kFew) return kFew;
  return std::min(kGrain, (bodies / kChunks + kVectors) / kVectors * kVectors);
}

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
    const Bodies<Real> bodies{mass.data(), force.data(), velocity.data(), position.data()};
    step.ParallelFor(mass.size(), Grain(mass.size()), [&](uint64_t begin, uint64_t end) {
      if (acceleration.present()) Accelerate(begin, end);
      compiled_.move(bodies, begin, end, dt);
    });
  }

  void Accelerate(uint64_t begin, uint64_t end) const {
    for (uint64_t i = begin; i < end; ++i) {
      acceleration[i] = mass[i] == 0 ? Vec3<Real>{} : force[i] * (1 / mass[i]);
    }
  }

 private:
  const Moves<Real> compiled_ = AvailableMoves<Real>().front();
};

}  // namespace

VESPER_LAW_LIBRARY("newton_motion", NewtonMotion)
