// SPDX-License-Identifier: Apache-2.0
// A law that ends the process of the engine in a chosen step, in one of four ways.
#include <csignal>
#include <cstdlib>

#include <unistd.h>

#include "vesper/law.hpp"

namespace {

using namespace vesper;

// NOLINTNEXTLINE(misc-no-recursion)
int Overflow(int depth) {
  volatile char page[4096];
  page[depth % 4096] = static_cast<char>(depth);
  return Overflow(depth + 1) + page[0];
}

/** A law that exerts 1 N on each body, and ends the process in step `step`. */
template <class Real>
struct Crash {
  static constexpr auto kName = "crash", kVersion = "1.0.0";
  static constexpr auto kDoc = "Ends the process of the engine in a chosen step.";
  static constexpr auto kPhase = Phase::kForce;

  Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
  Parameter step{"step", "Number of steps before the crash.", units::one, 0, 0, 1e9};
  Parameter kind{
      "kind", "0: SIGSEGV, 1: SIGABRT, 2: _exit, 3: overflow of the stack.", units::one, 0, 0, 3};

  auto Properties() { return std::tie(force); }
  auto Parameters() { return std::tie(step, kind); }

  void Advance(const Step& now) {
    for (uint64_t i = 0; i < force.size(); ++i) force[i].x += Real(1);
    if (now.index < static_cast<uint64_t>(step.value())) return;
    switch (static_cast<int>(kind.value())) {
      case 0:
        *reinterpret_cast<volatile int*>(8) = 1;
        break;
      case 1:
        std::abort();
      case 2:
        _exit(4);
      default:
        Overflow(0);
    }
  }
};

}  // namespace

VESPER_LAW_LIBRARY("crash", Crash)
