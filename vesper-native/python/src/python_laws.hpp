// SPDX-License-Identifier: Apache-2.0
// Laws in Python. The code is in libvesper_python.so, which is loaded when the first law in Python
// is opened.
#pragma once

#include <cstdint>
#include <string>

#include "vesper/engine.h"

namespace vesper::python {

/// Runs a file of Python laws, and prepares its laws for engines of a prototype. `versions`, if not
/// null, receives the versions of Python and of the packages that the file imports.
vesper_status PreparePython(const vesper_prototype& prototype, const std::string& source,
                            const void* text, uint64_t size, vesper_prepared_library** out,
                            vesper_error* error, std::string* versions = nullptr);

}  // namespace vesper::python
