// SPDX-License-Identifier: Apache-2.0
// Machine code of passes over rows that refer to no other rows.
#pragma once

#include "law_code.hpp"
#include "program_emitter.hpp"

namespace vesper::text {

/// Returns true if all columns of the program have one or three components, and each is written
/// once.
bool HasRowsCode(const LawCode& law, const PassCode& pass, const Program& program);

/// Emits the function MachineCode::rows, and returns its label.
asmjit::Label EmitRows(VectorAssembler& vectors, const LawCode& law, const Program& program);

}  // namespace vesper::text
