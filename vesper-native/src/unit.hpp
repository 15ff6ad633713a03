// SPDX-License-Identifier: Apache-2.0
// Units and scalar types: equality, validity, and text for messages.
#pragma once

#include <cstddef>
#include <string>

#include "vesper/types.h"

namespace vesper {

/// Maximum length [bytes] of the name of a property, kind, law, library or parameter; it must fit
/// `vesper_error`.
inline constexpr size_t kMaxNameLength = 47;

bool SameUnit(const vesper_unit& a, const vesper_unit& b);
/// Returns true if the units have the same dimension, so that a factor converts one to the other.
bool SameDimension(const vesper_unit& a, const vesper_unit& b);
/// Returns true for a finite positive scale, a terminated symbol and a zero reserved byte.
bool IsValidUnit(const vesper_unit& unit);
/// Returns the symbol and, if the symbol alone is ambiguous, the SI form: "N = m*kg*s^-2".
std::string Describe(const vesper_unit& unit);

/// Returns the bytes of one scalar of a column; 0 for a field or an unknown type.
size_t ScalarSize(vesper_scalar_type type);
bool IsReal(vesper_scalar_type type);
bool IsField(vesper_scalar_type type);
bool IsKnownType(vesper_scalar_type type);
/// Returns "f32", "f64", "i32", "u32", "field", or "unknown type".
const char* ScalarName(vesper_scalar_type type);
/// Returns, for example, "f64 x 3".
std::string DescribeType(vesper_scalar_type type, uint32_t components);

/// Returns true if `name` is 1 to kMaxNameLength bytes of ASCII letters, digits, "_" and "-".
bool IsValidName(const char* name);

}  // namespace vesper
