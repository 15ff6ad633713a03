// SPDX-License-Identifier: Apache-2.0
// One number for the whole state of an engine.
#pragma once

#include <cstdint>

#include "columns.hpp"

namespace vesper {

/// XXH3-64 over the step count, then the bound columns in prototype order, rows in row order, -0 as
/// +0. Columns are fresh.
uint64_t HashState(uint64_t step_count, const Columns& columns);

}  // namespace vesper
