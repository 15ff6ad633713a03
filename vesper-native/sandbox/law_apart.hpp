// SPDX-License-Identifier: Apache-2.0
// Law libraries whose laws run apart: in a sandbox, which can access only their columns.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sandbox.hpp"
#include "vesper/engine.h"

namespace vesper::apart {

/// Starts the thread that starts sandboxes, so that it does not count as a thread of a law.
void Prepare();

/// Opens a law library in a sandbox. The prepared library has the same table, but its laws are
/// proxies: they copy their columns to the sandbox, call the law there, and copy back what it
/// wrote. A proxy returns LAW_CRASHED or LAW_TIMED_OUT if the law ended the sandbox or did not
/// return in time; its next call starts another one. `log` receives the layers that the machine
/// lacks; it may be null. The engine that loads the library must be told of edits
/// (`vesper_engine_config.touches`).
vesper_status PrepareApart(const vesper_prototype& prototype, const Options& options,
                           std::span<const std::byte> bytes, const std::string& source,
                           vesper_prepared_library** out, vesper_error* error);

}  // namespace vesper::apart
