// SPDX-License-Identifier: Apache-2.0
// Laws as text as C++ laws.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "law_code.hpp"

namespace vesper::text {

/// Returns the source of a law library with the same laws, to be built like any compiled law. The
/// laws must be free of problems. `source` and `text` name and contain the laws as text.
std::string WriteCpp(std::string_view source, std::string_view text,
                     const std::vector<LawCode>& laws);

}  // namespace vesper::text
