// SPDX-License-Identifier: Apache-2.0
// Streaming passes over column memory. Values are `count` scalars, tightly packed.
#pragma once

#include <cstdint>

#include "vesper/types.h"

namespace vesper {

inline constexpr uint64_t kNotFound = UINT64_MAX;

/// Value `index` of reals.
double ValueAt(vesper_scalar_type type, const void* values, uint64_t index);

/// Index of the first NaN or infinity, or kNotFound. Integer types are always finite.
uint64_t FindNonFinite(vesper_scalar_type type, const void* values, uint64_t count);

/// sum[i] += addend[i]
void Add(vesper_scalar_type type, void* sum, const void* addend, uint64_t count);

/// What takes a value from a unit of scale `multiply` to one of scale `divide`.
struct UnitRatio {
  double multiply = 1;
  double divide = 1;

  bool IsOne() const { return multiply == divide; }
  UnitRatio Inverse() const { return {divide, multiply}; }
};
/// to[i] = from[i] * multiply / divide, computed in f64. Integers are left alone.
void Convert(vesper_scalar_type type, void* to, const void* from, UnitRatio ratio, uint64_t count);
/// The same where the bits of from[i] and before[i] differ.
void ConvertChanged(vesper_scalar_type type, void* to, const void* from, const void* before,
                    UnitRatio ratio, uint64_t count);

/// Fills reals with a quiet NaN of a pattern that no arithmetic makes; leaves integers alone.
void FillUnwritten(vesper_scalar_type type, void* values, uint64_t count);
/// Whether value `index` still holds that pattern.
bool IsUnwritten(vesper_scalar_type type, const void* values, uint64_t index);

/// Copies, with -0 made +0.
void CopyCanonical(vesper_scalar_type type, void* to, const void* from, uint64_t count);

/// Index of the first value that is not below `limit`, or kNotFound.
uint64_t FindOutOfRange(const uint32_t* values, uint64_t count, uint64_t limit);

/// Index of the first value below `minimum`, or kNotFound; NaN is not. Integer types
/// are left alone.
uint64_t FindBelow(vesper_scalar_type type, const void* values, uint64_t count, double minimum);

/// to[i] = from[indices[i]], rows of `row_size` bytes.
void Gather(void* to, const void* from, const uint32_t* indices, uint64_t count, uint64_t row_size);

}  // namespace vesper
