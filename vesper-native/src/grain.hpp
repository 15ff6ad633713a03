// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace vesper {

/// Returns the number of elements in each range of a `parallel_for` whose caller left the choice to
/// the engine.
inline uint64_t ChooseGrain(uint64_t count) {
  constexpr uint64_t kMinGrain = 1024;
  constexpr uint64_t kMaxChunks = 256;
  return std::max(kMinGrain, count / kMaxChunks + 1);
}

}  // namespace vesper
