// SPDX-License-Identifier: Apache-2.0
// Reports of the probe process to the engine over a pipe, one record per stage.
#pragma once

#include <cstdint>

#include "vesper/types.h"

namespace vesper {

/// File descriptors that the engine opens for the probe.
inline constexpr int kProbeLibraryFd = 3;
inline constexpr int kProbeReportFd = 4;

enum class ProbeStage : int32_t { kLoading, kCallingEntry, kReadingTable, kUnloading, kDone };

/// Report of the probe, written before each stage and at the end. It is so small that the kernel
/// writes it to a pipe atomically.
struct ProbeReport {
  ProbeStage stage;
  vesper_error error;  // a status other than OK: the reason to refuse the library
};

}  // namespace vesper
