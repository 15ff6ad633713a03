// SPDX-License-Identifier: Apache-2.0
// Decides whether a law is compatible with an engine, before any code of the law runs.
#pragma once

#include <memory>
#include <vector>

#include "columns.hpp"
#include "law_library.hpp"
#include "prototype.hpp"

namespace vesper {

/// Matches each use of `law` with a property. Throws NOT_FOUND, TYPE_MISMATCH, UNIT_MISMATCH or
/// ACCESS_CONFLICT with the law, the property, what was found and what was expected.
std::vector<MatchedUse> MatchUses(const vesper_law_desc& law, const Prototype& prototype,
                                  const Columns& columns);

/// Matches a field of library `library` with a property. Throws NOT_FOUND, TYPE_MISMATCH or
/// UNIT_MISMATCH with the same information.
std::unique_ptr<LoadedField> MatchField(const char* library, const vesper_field_desc& field,
                                        const Prototype& prototype);

/// Throws ACCESS_CONFLICT if these two laws cannot be loaded at the same time.
void CheckCompatible(const LoadedLaw& a, const LoadedLaw& b, const Prototype& prototype);

/// Returns values for the parameters of all `laws` of a library: given values, or defaults. Throws
/// NOT_FOUND for an unknown name, INVALID_ARGUMENT for an ambiguous name or a bad value, and
/// ALREADY_EXISTS for a name that is given twice.
std::vector<std::vector<double>> ResolveParameters(
    const std::vector<std::unique_ptr<LoadedLaw>>& laws, const vesper_parameter* parameters,
    uint32_t count);

}  // namespace vesper
