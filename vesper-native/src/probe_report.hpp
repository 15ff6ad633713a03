// SPDX-License-Identifier: Apache-2.0
// What the probe process tells the engine, one record per stage over a pipe.
#pragma once

#include <cstdint>

#include "vesper/types.h"

namespace vesper {

/// Descriptors that the engine opens for the probe.
inline constexpr int kProbeLibraryFd = 3;
inline constexpr int kProbeReportFd = 4;

enum class ProbeStage : int32_t { kLoading, kCallingEntry, kReadingTable, kUnloading, kDone };

/// Written before each stage, and at the end. Small enough for a pipe to keep whole.
struct ProbeReport {
  ProbeStage stage;
  vesper_error error;  // status other than OK: the library is refused for this reason
};

}  // namespace vesper
