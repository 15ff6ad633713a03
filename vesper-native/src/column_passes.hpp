// Passes over columns, by all threads where a column is long enough to be worth waking them.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "kernels.hpp"
#include "thread_pool.hpp"
#include "vesper/types.h"

namespace vesper {

/// Values that a thread takes at once: one chunk if they are too few to be worth waking another.
inline uint64_t PassGrain(uint64_t count) {
  constexpr uint64_t kFew = 1 << 15, kGrain = 1 << 13;
  return count <= kFew ? kFew : kGrain;
}

/// The smallest of what find(begin, end) answers for ranges that cover [0, count).
template <class Find>
uint64_t FindFirst(ThreadPool& pool, uint64_t count, const Find& find) {
  std::atomic<uint64_t> first = kNotFound;
  pool.ParallelFor(count, PassGrain(count), [&](uint64_t begin, uint64_t end) {
    const uint64_t found = find(begin, end);
    uint64_t before = first.load(std::memory_order_relaxed);
    while (found < before && !first.compare_exchange_weak(before, found)) {
    }
  });
  return first.load();
}

/// As in kernels.hpp.
uint64_t FindNonFinite(ThreadPool& pool, vesper_scalar_type type, const void* values,
                       uint64_t count);
void Zero(ThreadPool& pool, vesper_scalar_type type, void* values, uint64_t count);

}  // namespace vesper
