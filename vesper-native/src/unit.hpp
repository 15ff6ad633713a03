// SPDX-License-Identifier: Apache-2.0
// Units and scalar types: equality, validity, and how messages print them.
#pragma once

#include <cstddef>
#include <string>

#include "vesper/types.h"

namespace vesper {

/// Longest name of a property, kind, law, library or parameter: it has to fit `vesper_error`.
inline constexpr size_t kMaxNameLength = 47;

bool SameUnit(const vesper_unit& a, const vesper_unit& b);
/// Whether values of one can be converted to the other by a factor.
bool SameDimension(const vesper_unit& a, const vesper_unit& b);
/// Finite positive scale, terminated symbol, reserved byte zero.
bool IsValidUnit(const vesper_unit& unit);
/// The symbol and, where the symbol alone could mislead, the SI form: "N = m*kg*s^-2".
std::string Describe(const vesper_unit& unit);

/// Bytes of one scalar of a column; 0 for a field and for a number that is no scalar type.
size_t ScalarSize(vesper_scalar_type type);
bool IsReal(vesper_scalar_type type);
bool IsField(vesper_scalar_type type);
bool IsKnownType(vesper_scalar_type type);
/// "f32", "f64", "i32", "u32", "field", or "unknown type".
const char* ScalarName(vesper_scalar_type type);
/// "f64 x 3"
std::string DescribeType(vesper_scalar_type type, uint32_t components);

/// Whether `name` is 1 to kMaxNameLength bytes of ASCII letters, digits, "_" and "-".
bool IsValidName(const char* name);

}  // namespace vesper
