// SPDX-License-Identifier: Apache-2.0
// The time of a simulation.
#pragma once

#include <cstdint>

namespace vesper {

/// Counts steps, and the time that they took together [time unit of the prototype]. While `dt`
/// stays the same, time is computed by one multiplication, so that it does not drift.
struct StepClock {
  uint64_t steps = 0;
  uint64_t steps_of_dt = 0;  // of them, done with the present dt
  double dt = 0;
  double start_of_dt = 0;  // time when the present dt came into force

  double time() const { return start_of_dt + static_cast<double>(steps_of_dt) * dt; }

  void Tick(double step) {
    if (step != dt) *this = {steps, 0, step, time()};
    ++steps;
    ++steps_of_dt;
  }
};

}  // namespace vesper
