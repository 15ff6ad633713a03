// SPDX-License-Identifier: Apache-2.0
// Check that a file is a complete shared object, because an incomplete one could crash the dynamic
// loader.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace vesper {

/// Throws LIBRARY_LOAD_FAILED unless `file` is a 64-bit ELF shared object for this machine that
/// contains all its segments and its section table. `source` names the file in messages.
void CheckSharedObject(std::span<const std::byte> file, const std::string& source);

}  // namespace vesper
