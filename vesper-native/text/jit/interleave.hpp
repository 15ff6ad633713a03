// SPDX-License-Identifier: Apache-2.0
// Conversion of rows of three components in memory to three vectors, and back.
#pragma once

#include <array>
#include <functional>

#include "vector_assembler.hpp"

namespace vesper::text {

using VectorTriple = std::array<asmjit::x86::Vec, 3>;

/// Splits three vectors in the order of memory (x y z x y z …) into x, y, z.
VectorTriple SplitRows(VectorAssembler& vectors, const VectorTriple& memory);
/// Joins x, y, z to three vectors in the order of memory.
VectorTriple JoinRows(VectorAssembler& vectors, const VectorTriple& components);

/// Loads rows of three components that need not be adjacent. `address_of(i)` returns the memory of
/// row i.
VectorTriple GatherRows(VectorAssembler& vectors,
                        const std::function<asmjit::x86::Mem(uint32_t)>& address_of);
/// Loads one number of each row; `address_of(i)` returns the memory of the number of row i.
asmjit::x86::Vec GatherNumbers(VectorAssembler& vectors,
                               const std::function<asmjit::x86::Mem(uint32_t)>& address_of);

}  // namespace vesper::text
