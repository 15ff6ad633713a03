// SPDX-License-Identifier: Apache-2.0
// Law libraries whose laws run apart: in a sandbox, a process that can access only their columns.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sandbox.hpp"
#include "vesper/engine.h"

namespace vesper::apart {

/// Starts the thread that starts all sandboxes. Call it before any law is loaded, so that this
/// thread is not counted as a thread that a law started.
void Prepare();

/// Opens a law library in a sandbox. The prepared library has the same table, but its laws are
/// proxies. A proxy copies its columns to the sandbox, calls the law there, and copies back the
/// columns that the law wrote. It returns LAW_CRASHED if the law ended the sandbox, or
/// LAW_TIMED_OUT if the law did not return in time. Its next call starts a new sandbox. `log`
/// receives the layers of protection that the machine lacks; it may be null. The client of the
/// engine must touch edited arrays (`vesper_engine_config.touches`).
vesper_status PrepareApart(const vesper_prototype& prototype, const Options& options,
                           std::span<const std::byte> bytes, const std::string& source,
                           vesper_prepared_library** out, vesper_error* error);

}  // namespace vesper::apart
