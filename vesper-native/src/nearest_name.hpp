// SPDX-License-Identifier: Apache-2.0
// What a mistyped name most likely meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vesper {

/// The candidate with the fewest letters to change, or null if none is near.
const std::string* NearestName(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace vesper
