// SPDX-License-Identifier: Apache-2.0
// Hash of the whole state of an engine.
#pragma once

#include <cstdint>

#include "columns.hpp"

namespace vesper {

/// Returns a hash (XXH3-64) of the step count and the bound columns. The columns are in the order
/// of the prototype, their rows in row order, and -0 counts as +0. Columns must be current.
uint64_t HashState(uint64_t step_count, const Columns& columns);

}  // namespace vesper
