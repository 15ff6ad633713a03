// SPDX-License-Identifier: Apache-2.0
// Opens a library in a separate process, because a broken library crashes its process.
#pragma once

#include "config.hpp"
#include "prepared_library.hpp"

namespace vesper {

/// Loads the library in a separate process, checks its tables there and unloads it. Returns on
/// success. Otherwise throws what that process reported, how it ended, or that its deadline passed.
void ProbeLibrary(const Config& config, const SealedCopy& copy);

}  // namespace vesper
