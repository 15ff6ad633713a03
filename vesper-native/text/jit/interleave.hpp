// SPDX-License-Identifier: Apache-2.0
// Conversion of rows of three components in memory to three vectors, and back.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "vector_assembler.hpp"

namespace vesper::text {

using VectorTriple = std::array<asmjit::x86::Vec, 3>;

/// Splits three vectors in the order of memory (x y z x y z …) into x, y, z.
VectorTriple SplitRows(VectorAssembler& vectors, const VectorTriple& memory);
/// Joins x, y, z to three vectors in the order of memory.
VectorTriple JoinRows(VectorAssembler& vectors, const VectorTriple& components);

/// Masks for GatherRows: mask i selects the three components of place i of a vector. Each place has
/// room for four components. Empty on AVX2, which has no masks.
using PlaceMasks = std::vector<asmjit::x86::KReg>;
/// Emits code that sets the masks. It belongs before the loop that calls GatherRows.
PlaceMasks MakePlaceMasks(VectorAssembler& vectors);

/// Loads rows of three components that need not be adjacent. `address_of(i)` returns the memory of
/// row i. Reads no memory but that of the rows.
VectorTriple GatherRows(VectorAssembler& vectors, const PlaceMasks& masks,
                        const std::function<asmjit::x86::Mem(uint32_t)>& address_of);
/// Loads one number of each row; `address_of(i)` returns the memory of the number of row i.
asmjit::x86::Vec GatherNumbers(VectorAssembler& vectors,
                               const std::function<asmjit::x86::Mem(uint32_t)>& address_of);

}  // namespace vesper::text
