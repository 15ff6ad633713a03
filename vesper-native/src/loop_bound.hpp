// SPDX-License-Identifier: Apache-2.0
// The bound of the loops that laws run with `parallel_for`.
#pragma once

#include <cinttypes>
#include <cstdint>
#include <string>
#include <utility>

#include "failure.hpp"

namespace vesper {

/// Maximum number of elements of a `parallel_for`: more rows than any memory holds, and so few that
/// no sum of an element and a range overflows.
inline constexpr uint64_t kMaxLoop = uint64_t{1} << 40;

/// The number of elements of the last loop of this thread that was refused; 0 for none.
inline thread_local uint64_t refused_loop = 0;

/// Returns true if a loop must not run; the end of the law's call then reports it.
inline bool RefuseLoop(uint64_t count) {
  if (count <= kMaxLoop) return false;
  refused_loop = count;
  return true;
}

/// Throws LAW_MISBEHAVED if a loop of this thread was refused since the last call.
inline void ReportRefusedLoop(const std::string& caller) {
  const uint64_t count = std::exchange(refused_loop, 0);
  if (count == 0) return;
  throw Failure(VESPER_LAW_MISBEHAVED,
                "%sparallel_for over %" PRIu64 " elements, expected %" PRIu64
                " or fewer; count the rows, and check the difference of unsigned numbers",
                caller.c_str(), count, kMaxLoop);
}

}  // namespace vesper
