// The threads that laws share through their host.
#pragma once

#include <oneapi/tbb/task_arena.h>

#include <cstdint>
#include <optional>

namespace vesper {

/// A body of `parallel_for`, as in law.h.
using RangeBody = void (*)(void* user, uint64_t begin, uint64_t end);

class ThreadPool {
 public:
  /// `threads` counts the caller's.
  explicit ThreadPool(uint32_t threads);

  /// Calls `body` for chunks of `grain` that cover [0, count), whose borders depend on nothing
  /// else. `grain` 0: chosen from `count` alone. Returns when all are done.
  void ParallelFor(uint64_t count, uint64_t grain, RangeBody body, void* user);

 private:
  std::optional<tbb::task_arena> arena_;  // none with one thread
};

}  // namespace vesper
