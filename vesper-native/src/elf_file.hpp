// SPDX-License-Identifier: Apache-2.0
// Tells a complete shared object from anything that would crash the loader.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace vesper {

/// Throws LIBRARY_LOAD_FAILED unless `file` is a 64-bit ELF shared object for this machine with
/// every segment and the section table inside it. `source` names the file in messages.
void CheckSharedObject(std::span<const std::byte> file, const std::string& source);

}  // namespace vesper
