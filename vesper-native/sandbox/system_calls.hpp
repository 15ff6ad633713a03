// SPDX-License-Identifier: Apache-2.0
// The system calls that a sandbox may make.
#pragma once

namespace vesper::apart {

/// Permits the calls that the loader needs; a second call of FilterCalls restricts them further.
/// Other calls raise SIGSYS. Returns 0 or an error number.
enum class Stage { kLoading, kServing };
int FilterCalls(Stage stage);

}  // namespace vesper::apart
