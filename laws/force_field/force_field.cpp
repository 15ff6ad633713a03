// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

// Number of bodies per call of the field (kBatch), and per chunk of a thread (kGrain).
constexpr uint64_t kBatch = 128, kGrain = 8 * kBatch;

/** A force that is an arbitrary function of position: F(x), provided by the client or by a law
 *  library. */
template <class Real>
struct ForceField {
  static constexpr auto kName = "force_field", kVersion = "1.0.0";
  static constexpr auto kDoc = "Exerts the world's force field, a function of position, on bodies.";
  static constexpr auto kPhase = Phase::kForce;
  static constexpr uint32_t kClaims = kTranslation | kRotation;

  Field<Vec3<Real>> field{"forceField", "world", units::newton};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  auto Properties() { return std::tie(field, position, force); }

  void Advance(const Step& step) {
    step.ParallelFor(position.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      for (; begin < end; begin += kBatch) Exert(begin, std::min(end, begin + kBatch));
    });
  }

  void Exert(uint64_t begin, uint64_t end) const {
    double at[3 * kBatch]{}, out[3 * kBatch];
    double* next = at;
    for (uint64_t i = begin; i < end; ++i) {
      *next++ = position[i].x;
      *next++ = position[i].y;
      *next++ = position[i].z;
    }
    field.Evaluate(end - begin, at, out);
    const double* pushed = out;
    for (uint64_t i = begin; i < end; ++i, pushed += 3) {
      force[i] += Vec3<Real>{static_cast<Real>(pushed[0]), static_cast<Real>(pushed[1]),
                             static_cast<Real>(pushed[2])};
    }
  }
};

}  // namespace

VESPER_LAW_LIBRARY("force_field", ForceField)
