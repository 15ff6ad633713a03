// SPDX-License-Identifier: Apache-2.0
// Opens a library in a separate process first, because a broken library may crash the process that
// opens it.
#pragma once

#include "config.hpp"
#include "prepared_library.hpp"

namespace vesper {

/// Loads the library in a separate process, checks its tables there and unloads it. Returns on
/// success. Otherwise throws a failure with the process's report, or saying how it ended or that it
/// exceeded its deadline.
void ProbeLibrary(const Config& config, const SealedCopy& copy);

}  // namespace vesper
