// SPDX-License-Identifier: Apache-2.0
// Passes over columns; long columns are processed by all threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "kernels.hpp"
#include "thread_pool.hpp"
#include "vesper/types.h"

namespace vesper {

/// Division of a pass: number of values per chunk, and the threads that take part.
struct Sharing {
  uint64_t grain;
  Helpers helpers;
};

/// Chooses how threads share a pass. For few values, only threads that are awake take part, because
/// waking a thread takes longer. For very few values, only the calling thread takes part.
inline Sharing ShareOut(uint64_t values) {
  constexpr uint64_t kVeryFew = 1 << 12, kFew = 1 << 15, kGrain = 1 << 13, kChunks = 8;
  if (values > kFew) return {kGrain, Helpers::kAll};
  return {values > kVeryFew ? values / kChunks + 1 : kVeryFew, Helpers::kAwake};
}

/// Returns the smallest result of find(begin, end) over ranges that cover [0, count).
template <class Find>
uint64_t FindFirst(ThreadPool& pool, uint64_t count, const Find& find) {
  std::atomic<uint64_t> first = kNotFound;
  auto look = [&](uint64_t begin, uint64_t end) {
    const uint64_t found = find(begin, end);
    uint64_t before = first.load(std::memory_order_relaxed);
    while (found < before && !first.compare_exchange_weak(before, found)) {
    }
  };
  const Sharing sharing = ShareOut(count);
  pool.ParallelFor(count, sharing.grain, look, sharing.helpers);
  return first.load();
}

/// Parallel versions of the functions in kernels.hpp.
uint64_t FindNonFinite(ThreadPool& pool, vesper_scalar_type type, const void* values,
                       uint64_t count);
uint64_t FindImmense(ThreadPool& pool, vesper_scalar_type type, const void* values, uint64_t count);
void Zero(ThreadPool& pool, vesper_scalar_type type, void* values, uint64_t count);

}  // namespace vesper
