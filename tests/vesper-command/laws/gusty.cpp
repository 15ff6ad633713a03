// SPDX-License-Identifier: Apache-2.0
// Brings a field, and a law that reads it.
#include <cmath>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

template <class Real>
struct Gusty {
  static constexpr auto kName = "gusty", kVersion = "1.0.0";
  static constexpr auto kDoc = "Force of the gusts that the library brings.";
  static constexpr auto kPhase = Phase::kForce;

  Field<Vec3<Real>> gusts{"gusts", "world", units::newton};
  Read<Vec3<Real>> position{"position", "body", units::metre};
  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
  auto Properties() { return std::tie(gusts, position, force); }

  void Advance(const Step&) {
    for (uint64_t i = 0; i < position.size(); ++i) force[i] += gusts(position[i]);
  }
};

void Gust(void*, uint64_t count, const double* at, double* out) {
  for (uint64_t i = 0; i < 3 * count; ++i) out[i] = std::sin(at[i]);
}

constexpr vesper_field_desc kFields[] = {{sizeof(vesper_field_desc), 3, "gusts", "A force.",
                                          VESPER_UNIT_NEWTON, Gust, nullptr, nullptr, nullptr}};

}  // namespace

VESPER_LAW_LIBRARY_WITH_FIELDS(LIBRARY_NAME, kFields, Gusty)
