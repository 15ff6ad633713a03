// SPDX-License-Identifier: Apache-2.0
// Translation of laws as text to C++.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "law_code.hpp"

namespace vesper::text {

/// Returns the C++ source of a law library with the same laws. It is built like any compiled law.
/// The laws must be free of problems. `text` contains the laws as text, and `source` is its name.
std::string WriteCpp(std::string_view source, std::string_view text,
                     const std::vector<LawCode>& laws);

}  // namespace vesper::text
