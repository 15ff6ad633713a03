// SPDX-License-Identifier: Apache-2.0
// Suggestion of a known name for a mistyped one.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vesper {

/// Returns the candidate with the smallest edit distance, or null if none is similar enough.
const std::string* NearestName(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace vesper
