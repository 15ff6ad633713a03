// SPDX-License-Identifier: Apache-2.0
// A law that loads well and then breaks its word: it writes NaN.
#include <limits>

#include "vesper/law.hpp"

using namespace vesper;

template <class Real>
struct NanWriter {
  static constexpr auto kName = "nan_writer", kVersion = "1.0.0";
  static constexpr auto kDoc = "Writes NaN into the velocity of row 1.";
  static constexpr auto kPhase = Phase::kConstrain;

  ReadWrite<Vec3<Real>> velocity{"velocity", "body", units::metre_per_second};
  auto Properties() { return std::tie(velocity); }
  void Advance(const Step&) { velocity[1].x = std::numeric_limits<Real>::quiet_NaN(); }
};

VESPER_LAW_LIBRARY("nan_writer", NanWriter)
