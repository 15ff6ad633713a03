// SPDX-License-Identifier: Apache-2.0
// The threads on which laws run, also in `parallel_for`.
#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>

namespace vesper {

/// A body of `parallel_for`, as in law.h.
using RangeBody = void (*)(void* user, uint64_t begin, uint64_t end);

/// The threads that take part in a loop: all, or only threads that are awake. Waking a thread takes
/// about 10 us.
enum class Helpers { kAll, kAwake };

class ThreadPool {
 public:
  /// Creates a pool; `threads` includes the caller's thread.
  explicit ThreadPool(uint32_t threads);
  ~ThreadPool();

  uint32_t threads() const { return threads_; }
  /// Returns the index of the calling thread, below threads(): 0 for the client's own thread.
  uint32_t this_thread() const;

  /// Calls `body` for chunks of `grain` elements that cover [0, count), and returns when all calls
  /// have returned. The chunks depend on `count` and `grain` only. If `grain` is 0, the pool
  /// chooses it by `count`. Call this function from bodies of ForEach, or from one thread at a
  /// time; not from the body of another ParallelFor.
  void ParallelFor(uint64_t count, uint64_t grain, RangeBody body, void* user,
                   Helpers helpers = Helpers::kAll);
  /// Runs a loop like the function above; `body` is called as body(begin, end).
  template <class Body>
  void ParallelFor(uint64_t count, uint64_t grain, Body&& body, Helpers helpers = Helpers::kAll) {
    const auto call = [](void* user, uint64_t begin, uint64_t end) {
      (*static_cast<std::remove_reference_t<Body>*>(user))(begin, end);
    };
    ParallelFor(count, grain, call, &body, helpers);
  }

  /// Calls body(i) for every i below `count`, possibly concurrently, and returns when all calls
  /// have returned. It is intended for few calls with much work. The body may call ParallelFor.
  template <class Body>
  void ForEach(uint64_t count, Body& body) {
    RunEach(count, [](void* user, uint64_t i) { (*static_cast<Body*>(user))(i); }, &body);
  }

 private:
  class Team;

  void RunEach(uint64_t count, void (*body)(void* user, uint64_t i), void* user);

  uint32_t threads_;
  std::unique_ptr<Team> team_;  // null if there is only one thread
};

}  // namespace vesper
