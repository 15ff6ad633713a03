// SPDX-License-Identifier: Apache-2.0
// Opens a library in a process of its own, because a broken one takes its process down.
#pragma once

#include "config.hpp"
#include "prepared_library.hpp"

namespace vesper {

/// Returns if the library loads, passes its table check and unloads in a process of its own; else
/// throws what that process reported, or how it ended, or that it overran its deadline.
void ProbeLibrary(const Config& config, const SealedCopy& copy);

}  // namespace vesper
