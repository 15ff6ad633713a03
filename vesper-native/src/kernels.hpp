// SPDX-License-Identifier: Apache-2.0
// Functions that process the memory of a column in one pass. Values are `count` scalars, tightly
// packed.
#pragma once

#include <cstdint>

#include "vesper/types.h"

namespace vesper {

inline constexpr uint64_t kNotFound = UINT64_MAX;

/// Returns value `index` of an array of reals.
double ValueAt(vesper_scalar_type type, const void* values, uint64_t index);

/// Returns the index of the first NaN or infinity, or kNotFound. Integer types are always finite.
uint64_t FindNonFinite(vesper_scalar_type type, const void* values, uint64_t count);

/// Returns the same as FindNonFinite, but also finds f64 magnitudes of 2^333 (1.7e100) or more.
uint64_t FindImmense(vesper_scalar_type type, const void* values, uint64_t count);

/// Computes sum[i] += addend[i].
void Add(vesper_scalar_type type, void* sum, const void* addend, uint64_t count);

/// Factor and divisor that convert a value from a unit of scale `multiply` to a unit of scale
/// `divide`.
struct UnitRatio {
  double multiply = 1;
  double divide = 1;

  bool IsOne() const { return multiply == divide; }
  UnitRatio Inverse() const { return {divide, multiply}; }
};
/// Computes to[i] = from[i] * multiply / divide in f64. Leaves integers unchanged.
void Convert(vesper_scalar_type type, void* to, const void* from, UnitRatio ratio, uint64_t count);
/// Converts as Convert does, but only the values whose bits differ in `from` and `before`.
void ConvertChanged(vesper_scalar_type type, void* to, const void* from, const void* before,
                    UnitRatio ratio, uint64_t count);

/// Fills reals with a quiet NaN whose pattern no arithmetic produces; leaves integers unchanged.
void FillUnwritten(vesper_scalar_type type, void* values, uint64_t count);
/// Returns true if value `index` still has the pattern of FillUnwritten.
bool IsUnwritten(vesper_scalar_type type, const void* values, uint64_t index);

/// Copies values and replaces -0 by +0.
void CopyCanonical(vesper_scalar_type type, void* to, const void* from, uint64_t count);

/// Returns the index of the first value that is not below `limit`, or kNotFound.
uint64_t FindOutOfRange(const uint32_t* values, uint64_t count, uint64_t limit);

/// Returns the index of the first value below `minimum`, or kNotFound. NaN is not below. Integer
/// types are ignored.
uint64_t FindBelow(vesper_scalar_type type, const void* values, uint64_t count, double minimum);

/// Computes to[i] = from[indices[i]] for rows of `row_size` bytes.
void Gather(void* to, const void* from, const uint32_t* indices, uint64_t count, uint64_t row_size);

}  // namespace vesper
