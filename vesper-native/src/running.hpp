// SPDX-License-Identifier: Apache-2.0
// Shows observers of an engine which law each of its threads is calling.
#pragma once

#include <atomic>
#include <cstdint>

#include "thread_pool.hpp"

namespace vesper {

/// Writes the entries of one law to the array `vesper_engine_config.running`.
class Running {
 public:
  Running(uint64_t* words, const ThreadPool& pool, uint32_t library, uint32_t law)
      : words_(words), pool_(pool), value_((uint64_t{library} << 32) | (law + 1)) {}

  /// While this object lives, the array shows that the calling thread is inside the law.
  class Inside {
   public:
    explicit Inside(const Running& running) {
      if (running.words_ == nullptr) return;
      word_ = running.words_ + running.pool_.this_thread();
      before_ = std::atomic_ref(*word_).exchange(running.value_, std::memory_order_relaxed);
    }
    ~Inside() {
      if (word_ != nullptr) std::atomic_ref(*word_).store(before_, std::memory_order_relaxed);
    }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;

   private:
    uint64_t* word_ = nullptr;
    uint64_t before_ = 0;
  };

 private:
  uint64_t* words_;  // null: no observer
  const ThreadPool& pool_;
  uint64_t value_;
};

}  // namespace vesper
