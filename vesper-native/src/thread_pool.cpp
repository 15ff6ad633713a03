#include "thread_pool.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>

#include "floating_point.hpp"
#include "thread_sanitizer.hpp"

namespace vesper {
namespace {

constexpr uint64_t kMinGrain = 1024;
constexpr uint64_t kMaxChunks = 256;
constexpr uint32_t kMaxThreads = 256;  // of one process, at least what a config may ask for

uint64_t ChooseGrain(uint64_t count) { return std::max(kMinGrain, count / kMaxChunks + 1); }

/** Chunks of a loop, dealt out in shares, one for each thread. A thread gets about the same part of
 *  the rows in every loop, so that they stay in its processor's caches. Moving rows to another
 *  processor costs about what short loops compute: only who has waited takes from a share that its
 *  thread has begun. */
class Shares {
 public:
  Shares(uint64_t chunks, uint32_t threads)
      : count_(static_cast<uint32_t>(std::min<uint64_t>(chunks, threads))) {
    for (uint64_t i = 0; i < count_; ++i) {
      shares_[i].Fill(chunks * i / count_, chunks * (i + 1) / count_);
    }
  }

  uint32_t count() const { return count_; }

  /// Calls each(chunk) for what nobody took yet, of its own share first.
  template <class Each>
  void Work(uint32_t own, const Each& each) {
    shares_[own].Empty(each);
    const auto patience = Clock::now() + kPatience;
    for (uint32_t i = 1; i < count_; ++i) {
      Share& share = shares_[(own + i) % count_];
      while (share.IsInWork() && Clock::now() < patience) std::this_thread::yield();
      share.Empty(each);
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::microseconds kPatience{30};

  /// Left without a value where there are fewer of them.
  class alignas(64) Share {
   public:
    void Fill(uint64_t begin, uint64_t end) {
      begin_ = next_ = begin;
      end_ = end;
    }
    bool IsInWork() {
      const uint64_t next = std::atomic_ref(next_).load(std::memory_order_relaxed);
      return next > begin_ && next < end_;
    }
    template <class Each>
    void Empty(const Each& each) {
      for (uint64_t chunk = Take(); chunk < end_; chunk = Take()) each(chunk);
    }

   private:
    uint64_t Take() { return std::atomic_ref(next_).fetch_add(1, std::memory_order_relaxed); }

    uint64_t begin_, end_, next_;
  };

  uint32_t count_;
  std::array<Share, kMaxThreads> shares_;
};

/// Lets `loop` call its argument, which is run(i), on the threads of `arena`.
template <class Run, class Loop>
void Fork(tbb::task_arena& arena, const Run& run, const Loop& loop) {
  char fork = 0, join = 0;  // two points in time, for the thread sanitizer
  ComesBefore(&fork);
  arena.execute([&] {
    loop([&](uint64_t i) {
      ComesAfter(&fork);
      const FloatingPointGuard guard;
      run(i);
      ComesBefore(&join);
    });
  });
  ComesAfter(&join);
}

}  // namespace

ThreadPool::ThreadPool(uint32_t threads) : threads_(threads) {
  if (threads == 1) return;
  // TBB would quietly stop at the number of cores, or at what the first arena asked for.
  static const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, kMaxThreads);
  arena_.emplace(static_cast<int>(threads));
}

void ThreadPool::ParallelFor(uint64_t count, uint64_t grain, RangeBody body, void* user) {
  if (count == 0) return;
  if (grain == 0) grain = ChooseGrain(count);
  const uint64_t chunks = (count - 1) / grain + 1;
  const auto run = [=](uint64_t chunk) {
    const uint64_t begin = chunk * grain;
    body(user, begin, begin + std::min(grain, count - begin));
  };
  if (!arena_ || chunks == 1) {
    for (uint64_t chunk = 0; chunk < chunks; ++chunk) run(chunk);
    return;
  }
  Shares shares(chunks, threads_);
  Fork(*arena_, run, [&shares](const auto& each) {
    const auto work = [&](uint32_t own) { shares.Work(own, each); };
    // While it waits for its last rows, a law must not be kept under another law that its thread
    // took up meanwhile.
    tbb::this_task_arena::isolate([&] {
      tbb::parallel_for(uint32_t{0}, shares.count(), work, tbb::static_partitioner());
    });
  });
}

void ThreadPool::RunEach(uint64_t count, void (*body)(void* user, uint64_t i), void* user) {
  const auto run = [=](uint64_t i) { body(user, i); };
  if (!arena_ || count == 1) {
    for (uint64_t i = 0; i < count; ++i) run(i);
    return;
  }
  Fork(*arena_, run, [count](const auto& each) {
    tbb::parallel_for(uint64_t{0}, count, each, tbb::simple_partitioner());  // a task for each
  });
}

}  // namespace vesper
