// SPDX-License-Identifier: Apache-2.0
// What lives in an engine and nowhere else, as bytes: the steps done and their time, and what
// laws remember.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scratch_column.hpp"
#include "step_clock.hpp"

namespace vesper {

/// One law's scratch, and the words that say which: "hooke_spring/hooke_spring 1.0.0/sum: f64 x 1
/// per body". Only scratch of the same name holds the same.
struct NamedScratch {
  std::string name;
  ScratchColumn* column;
};

struct EngineState {
  StepClock clock;
  std::string prototype;
  std::vector<NamedScratch> scratch;
};

/// A header with a version, the state, and a checksum over both. Numbers are as this machine has
/// them.
std::vector<std::byte> SaveState(const EngineState& state);

/// Fills the columns of `state` with what was saved under their names, and returns the clock.
/// Throws INVALID_ARGUMENT if `saved` is no saved state or a damaged one, ACCESS_CONFLICT if it is
/// that of another prototype or of other laws; then nothing is changed.
StepClock LoadState(std::span<const std::byte> saved, const EngineState& state);

}  // namespace vesper
