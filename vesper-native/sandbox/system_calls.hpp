// SPDX-License-Identifier: Apache-2.0
// The system calls that a sandbox may make.
#pragma once

namespace vesper::apart {

/// Stages of a sandbox, which permit different system calls.
enum class Stage { kLoading, kServing };
/// Permits only the system calls that the stage needs; other calls raise SIGSYS. Call it for
/// kLoading first: the call for kServing restricts the permitted calls further. Returns 0 or an
/// error number.
int FilterCalls(Stage stage);

}  // namespace vesper::apart
