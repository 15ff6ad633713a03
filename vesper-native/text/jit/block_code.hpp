// SPDX-License-Identifier: Apache-2.0
// Machine code of the operations on one block.
#pragma once

#include "law_code.hpp"
#include "program_emitter.hpp"

namespace vesper::text {

/// Emits the function MachineCode::run, and returns its label.
asmjit::Label EmitRun(VectorAssembler& vectors, const Program& program);

/// Emits the function MachineCode::gather, and returns its label.
asmjit::Label EmitGather(VectorAssembler& vectors, const LawCode& law, const Program& program);

}  // namespace vesper::text
