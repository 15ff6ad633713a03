// SPDX-License-Identifier: Apache-2.0
// Which of the loops that are compiled several times a processor can run.
#pragma once

namespace vesper {

/// What loops are compiled for.
enum class InstructionSet { kBaseline, kAvx2, kAvx512 };

/// The best one that this processor has.
InstructionSet BestInstructionSet();

}  // namespace vesper
