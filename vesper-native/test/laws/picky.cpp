// SPDX-License-Identifier: Apache-2.0
// A law whose constructor throws: PICKY is the exception.
#include <stdexcept>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

template <class Real>
struct Picky {
  static constexpr auto kName = "picky", kVersion = "1.0.0";
  static constexpr auto kDoc = "Cannot be constructed.";
  static constexpr auto kPhase = Phase::kForce;

  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};

  Picky() { throw PICKY; }

  auto Properties() { return std::tie(force); }
  void Advance(const Step&) {}
};

}  // namespace

VESPER_LAW_LIBRARY("picky", Picky)
