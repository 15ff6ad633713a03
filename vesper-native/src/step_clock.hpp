// SPDX-License-Identifier: Apache-2.0
// The time of a simulation.
#pragma once

#include <cstdint>

namespace vesper {

/// Counter of steps and of their total time [time unit of the prototype]. While `dt` is constant,
/// the time is computed by one multiplication, so it does not drift.
struct StepClock {
  uint64_t steps = 0;
  uint64_t steps_of_dt = 0;  // number of steps with the current dt
  double dt = 0;
  double start_of_dt = 0;  // time at the first step with the current dt

  double time() const { return start_of_dt + static_cast<double>(steps_of_dt) * dt; }

  void Tick(double step) {
    if (step != dt) *this = {steps, 0, step, time()};
    ++steps;
    ++steps_of_dt;
  }
};

}  // namespace vesper
