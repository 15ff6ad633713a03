// SPDX-License-Identifier: Apache-2.0
// A law whose constructor throws after both precisions have been declared.
#include <stdexcept>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

int made = 0;

template <class Real>
struct Unmakable {
  static constexpr auto kName = "sdk_unmakable", kVersion = "1.0.0", kDoc = "Cannot be made.";
  static constexpr auto kPhase = Phase::kObserve;
  Read<Real> mass{"mass", "body", units::kilogram};

  Unmakable() {
    if (++made > 2) throw std::runtime_error("thrown by the constructor");
  }
  auto Properties() { return std::tie(mass); }
  void Advance(const Step&) {}
};

}  // namespace

VESPER_LAW_LIBRARY("sdk_unmakable", Unmakable)
