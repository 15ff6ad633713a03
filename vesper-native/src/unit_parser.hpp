// SPDX-License-Identifier: Apache-2.0
// Units as people write them: "N/m", "kg*m^2/s^2", "km/h".
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "vesper/types.h"

namespace vesper {

/// The unit that `text` stands for; throws INVALID_ARGUMENT that names text, column, what was
/// found and what was expected. The grammar is that of `vesper_unit_parse`.
vesper_unit ParseUnit(std::string_view text);

/// Where a text that ParseUnit refuses goes wrong, for callers that know line and file.
struct UnitError {
  size_t offset;        // into the text, in bytes
  std::string message;  // what was found, what was expected
};

/// The same; throws UnitError.
vesper_unit ParseUnitOrThrowWhere(std::string_view text);

}  // namespace vesper
