// SPDX-License-Identifier: Apache-2.0
// The only function that libvesper_python.so exports.
#pragma once

#include <cstdint>

#include "vesper/engine.h"

extern "C" {

/// Runs a file of laws in Python (`text`, `size` bytes) and returns its functions as a library for
/// engines of `prototype`. Embeds Python at the first call, for the rest of the process. `source`
/// is the name of the file in messages. `versions` receives the versions of Python and of the
/// packages that the file imports, in `versions_size` bytes with a zero at the end. Any thread.
VESPER_API vesper_status vesper_python_prepare(const vesper_prototype* prototype,
                                               const char* source, const char* text, uint64_t size,
                                               char* versions, uint64_t versions_size,
                                               vesper_prepared_library** out, vesper_error* error);
}
