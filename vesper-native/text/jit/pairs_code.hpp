// SPDX-License-Identifier: Apache-2.0
// Machine code of passes over all pairs.
#pragma once

#include "program_emitter.hpp"

namespace vesper::text {

/// Emits the function MachineCode::pairs, and returns its label.
asmjit::Label EmitPairs(VectorAssembler& vectors, const Program& program, const Graph& graph);

}  // namespace vesper::text
