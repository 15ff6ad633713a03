// SPDX-License-Identifier: Apache-2.0
// The threads that laws run on, and share through their host.
#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>

namespace vesper {

/// A body of `parallel_for`, as in law.h.
using RangeBody = void (*)(void* user, uint64_t begin, uint64_t end);

/// Which threads a loop is for. Waking one that sleeps takes some 10 us.
enum class Helpers { kAll, kAwake };

class ThreadPool {
 public:
  /// `threads` counts the caller's.
  explicit ThreadPool(uint32_t threads);
  ~ThreadPool();

  uint32_t threads() const { return threads_; }

  /// Calls `body` for chunks of `grain` that cover [0, count), whose borders depend on nothing
  /// else. `grain` 0: chosen from `count` alone. Returns when all are done. From bodies of ForEach,
  /// or from one thread at a time; not from another loop's body.
  void ParallelFor(uint64_t count, uint64_t grain, RangeBody body, void* user,
                   Helpers helpers = Helpers::kAll);
  /// The same with body(begin, end).
  template <class Body>
  void ParallelFor(uint64_t count, uint64_t grain, Body&& body, Helpers helpers = Helpers::kAll) {
    const auto call = [](void* user, uint64_t begin, uint64_t end) {
      (*static_cast<std::remove_reference_t<Body>*>(user))(begin, end);
    };
    ParallelFor(count, grain, call, &body, helpers);
  }

  /// Calls body(i) for every i below `count`, perhaps at the same time, and returns when all are
  /// done. Meant for few and large bodies, which may call ParallelFor themselves.
  template <class Body>
  void ForEach(uint64_t count, Body& body) {
    RunEach(count, [](void* user, uint64_t i) { (*static_cast<Body*>(user))(i); }, &body);
  }

 private:
  class Team;

  void RunEach(uint64_t count, void (*body)(void* user, uint64_t i), void* user);

  uint32_t threads_;
  std::unique_ptr<Team> team_;  // null with one thread
};

}  // namespace vesper
