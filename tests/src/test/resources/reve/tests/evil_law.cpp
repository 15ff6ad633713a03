// SPDX-License-Identifier: Apache-2.0
// A law that fits every world, and whose library leaves a mark as soon as it is opened.
#include <cstdio>

#include "vesper/law.hpp"

#ifndef EVIL_LIBRARY
#define EVIL_LIBRARY "evil"
#endif
#ifndef EVIL_LAW
#define EVIL_LAW "evil"
#endif

using namespace vesper;

__attribute__((constructor)) static void LeaveMark() {
  if (FILE* mark = std::fopen(EVIL_MARK, "a")) {
    std::fputs("opened\n", mark);
    std::fclose(mark);
  }
}

template <class Real>
struct Evil {
  static constexpr auto kName = EVIL_LAW, kVersion = "1.0.0";
  static constexpr auto kDoc = "Pulls every body along x.";
  static constexpr auto kPhase = Phase::kForce;

  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
  auto Properties() { return std::tie(force); }
  void Advance(const Step&) {
    for (uint64_t i = 0; i < force.size(); ++i) force[i].x += Real(1);
  }
};

VESPER_LAW_LIBRARY(EVIL_LIBRARY, Evil)
