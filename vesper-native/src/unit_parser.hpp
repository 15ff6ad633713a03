// SPDX-License-Identifier: Apache-2.0
// Parser of units such as "N/m", "kg*m^2/s^2", "km/h".
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "vesper/types.h"

namespace vesper {

/// Parses `text`. Throws INVALID_ARGUMENT with text, column, what was found and what was expected.
/// The grammar is that of `vesper_unit_parse`.
vesper_unit ParseUnit(std::string_view text);

/// Position and message of a parse error, for callers that know line and file.
struct UnitError {
  size_t offset;        // offset in the text, in bytes
  std::string message;  // what was found and what was expected
};

/// Parses `text`; throws UnitError.
vesper_unit ParseUnitOrThrowWhere(std::string_view text);

}  // namespace vesper
