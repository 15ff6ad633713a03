// SPDX-License-Identifier: Apache-2.0
// Selection among loops that are compiled for several instruction sets.
#pragma once

namespace vesper {

/// Instruction sets for which loops are compiled.
enum class InstructionSet { kBaseline, kAvx2, kAvx512 };

/// Returns the best set that this processor supports.
InstructionSet BestInstructionSet();

}  // namespace vesper
