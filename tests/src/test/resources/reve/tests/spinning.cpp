// SPDX-License-Identifier: Apache-2.0
// A law that loads well and then never returns.
#include "vesper/law.hpp"

using namespace vesper;

template <class Real>
struct Spinning {
  static constexpr auto kName = "spinning", kVersion = "1.0.0";
  static constexpr auto kDoc = "Never returns.";
  static constexpr auto kPhase = Phase::kConstrain;

  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  auto Properties() { return std::tie(velocity); }
  void Advance(const Step&) {
    volatile bool forever = true;
    while (forever) {
    }
  }
};

VESPER_LAW_LIBRARY("spinning", Spinning)
