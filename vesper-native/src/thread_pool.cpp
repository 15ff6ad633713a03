#include "thread_pool.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "floating_point.hpp"
#include "thread_sanitizer.hpp"

namespace vesper {
namespace {

constexpr uint64_t kMinGrain = 1024;
constexpr uint64_t kMaxChunks = 256;
constexpr size_t kMaxThreads = 256;  // of one process, at least what a config may ask for

uint64_t ChooseGrain(uint64_t count) { return std::max(kMinGrain, count / kMaxChunks + 1); }

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
  Fork(*arena_, run, [chunks](const auto& each) {
    // While it waits for its last rows, a law must not be kept under another law that its thread
    // took up meanwhile.
    tbb::this_task_arena::isolate([&] { tbb::parallel_for(uint64_t{0}, chunks, each); });
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
