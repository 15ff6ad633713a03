// SPDX-License-Identifier: Apache-2.0
// Opens a library in a separate process first, because a broken library may crash the process that
// opens it.
#pragma once

#include "config.hpp"
#include "prepared_library.hpp"

namespace vesper {

/// Loads the library in a separate process, checks its tables there and unloads it. If this fails,
/// throws a failure. Its message is the report of the process, how the process ended, or that it
/// exceeded its deadline.
void ProbeLibrary(const Config& config, const SealedCopy& copy);

}  // namespace vesper
