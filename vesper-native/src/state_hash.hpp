// SPDX-License-Identifier: Apache-2.0
// Hash of the whole state of an engine.
#pragma once

#include <cstdint>

#include "columns.hpp"

namespace vesper {

/// Returns XXH3-64 over the step count, then the bound columns in prototype order, rows in row
/// order, -0 as +0. Columns must be current.
uint64_t HashState(uint64_t step_count, const Columns& columns);

}  // namespace vesper
