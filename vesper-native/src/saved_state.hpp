// SPDX-License-Identifier: Apache-2.0
// Serialisation of the state that only the engine has: step count, time, and SCRATCH values of
// laws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "scratch_column.hpp"
#include "step_clock.hpp"

namespace vesper {

/// The values of one SCRATCH use and their description, e.g. "hooke_spring/hooke_spring 1.0.0/sum:
/// f64 x 1 per body". They can be restored only to a SCRATCH use with the same description.
struct NamedScratch {
  std::string name;
  ScratchColumn* column;
};

struct EngineState {
  StepClock clock;
  std::string prototype;
  std::vector<NamedScratch> scratch;
};

/// Returns the bytes of a saved state: a header with a version, the state, and a checksum over
/// both. Numbers have the byte order of this machine.
std::vector<std::byte> SaveState(const EngineState& state);

/// Fills the columns of `state` with the values that were saved under the same descriptions, and
/// returns step count and time. Throws INVALID_ARGUMENT if `saved` is not a saved state or is
/// damaged, ACCESS_CONFLICT if it belongs to another prototype or to other laws. On failure nothing
/// changes.
StepClock LoadState(std::span<const std::byte> saved, const EngineState& state);

/// Returns `saved` without the scratch of a library's laws. Throws INVALID_ARGUMENT as LoadState
/// does.
std::vector<std::byte> WithoutLibrary(std::span<const std::byte> saved, const std::string& library);

}  // namespace vesper
