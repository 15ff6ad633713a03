// SPDX-License-Identifier: Apache-2.0
#include "thread_pool.hpp"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <new>
#include <thread>
#include <vector>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "floating_point.hpp"
#include "thread_sanitizer.hpp"

namespace vesper {
namespace {

using Clock = std::chrono::steady_clock;

constexpr uint64_t kMinGrain = 1024;
constexpr uint64_t kMaxChunks = 256;
constexpr uint32_t kMaxThreads = 256;  // of one process, at least what a config may ask for

uint64_t ChooseGrain(uint64_t count) { return std::max(kMinGrain, count / kMaxChunks + 1); }

/// Tells the processor that this thread waits.
inline void Pause() {
#if defined(__x86_64__)
  _mm_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Waiting for another thread: at first ready to go on at once, then giving way to others.
class Wait {
 public:
  void Moment() {
    if (Clock::now() < ready_until_) {
      Pause();
    } else {
      std::this_thread::yield();
    }
  }

 private:
  static constexpr std::chrono::microseconds kReady{20};

  Clock::time_point ready_until_ = Clock::now() + kReady;
};

/** A loop, its chunks dealt out in shares, one for each thread. A thread gets about the same part
 *  of the rows in every loop, so that they stay in its processor's caches. Moving rows to another
 *  processor costs about what short loops compute: only who has waited takes from a share that its
 *  thread has begun. */
class Loop {
 public:
  Loop(uint64_t count, uint64_t grain, RangeBody body, void* user, uint32_t threads)
      : count_(count), grain_(grain), body_(body), user_(user) {
    const uint64_t chunks = (count - 1) / grain + 1;
    shares_in_use_ = static_cast<uint32_t>(std::min<uint64_t>(chunks, threads));
    for (uint64_t i = 0; i < shares_in_use_; ++i) {
      shares_[i].Fill(chunks * i / shares_in_use_, chunks * (i + 1) / shares_in_use_);
    }
    ComesBefore(&begin_);
  }
  ~Loop() { ComesAfter(&end_); }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  uint32_t shares() const { return shares_in_use_; }

  /// Does the chunks that nobody took yet, of its own share first.
  void Work(uint32_t own) {
    ComesAfter(&begin_);
    const FloatingPointGuard guard;
    Empty(shares_[own]);
    const auto patience = Clock::now() + kPatience;
    for (uint32_t i = 1; i < shares_in_use_; ++i) {
      Share& share = shares_[(own + i) % shares_in_use_];
      Wait wait;
      while (share.IsInWork() && Clock::now() < patience) wait.Moment();
      Empty(share);
    }
    ComesBefore(&end_);
  }

 private:
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
    uint64_t Take() { return std::atomic_ref(next_).fetch_add(1, std::memory_order_relaxed); }
    uint64_t end() const { return end_; }

   private:
    uint64_t begin_, end_, next_;
  };

  void Empty(Share& share) {
    for (uint64_t chunk = share.Take(); chunk < share.end(); chunk = share.Take()) {
      const uint64_t begin = chunk * grain_;
      body_(user_, begin, begin + std::min(grain_, count_ - begin));
    }
  }

  uint64_t count_, grain_;
  RangeBody body_;
  void* user_;
  uint32_t shares_in_use_;
  char begin_ = 0, end_ = 0;  // two points in time, for the thread sanitizer
  std::array<Share, kMaxThreads> shares_;
};

/** Where a helper looks for the next loop, and is given it. Whoever runs loops, one thread at a
 *  time, offers and withdraws them. */
class alignas(64) Seat {
 public:
  /// Gives the loop to the helper, and returns true, if one is here.
  bool Offer(Loop& loop) {
    loop_ = &loop;
    return Change(State::kFree, State::kOffered);
  }
  /// Leaves the loop, after Offer returned false, for a helper that is called now.
  void Leave(Loop& loop) {
    loop_ = &loop;
    state_ = State::kOffered;
  }
  /// Returns when nobody works on the loop any more; if nobody began, nobody will.
  void Withdraw() {
    if (Change(State::kOffered, State::kFree)) return;
    for (Wait wait; Is(State::kTaken);) wait.Moment();
  }
  /// Sends the helper away, and one that is on its way; not between Offer and Withdraw.
  void Dismiss() { state_ = State::kAway; }

  /// The helper's part: does this share of loops, and after each looks so long for the next one.
  void Help(uint32_t share, Clock::duration look) {
    auto until = Clock::now() + look;
    for (; !Is(State::kAway); Pause()) {
      if (Is(State::kOffered) && Change(State::kOffered, State::kTaken)) {
        loop_->Work(share);
        state_ = State::kFree;
        until = Clock::now() + look;
      } else if (Clock::now() >= until) {
        // If it is taken, then by one who came after this one had been dismissed.
        if (Change(State::kFree, State::kAway) || Is(State::kTaken)) return;
      }
    }
  }

 private:
  enum class State { kAway, kFree, kOffered, kTaken };

  bool Is(State state) const { return state_.load(std::memory_order_acquire) == state; }
  bool Change(State from, State to) { return state_.compare_exchange_strong(from, to); }

  std::atomic<State> state_ = State::kAway;
  Loop* loop_ = nullptr;  // written while nobody can take it
};

}  // namespace

/** TBB's threads, which come when called and look a while for the next loop before they go: so a
 *  step's short loops find them awake. */
class ThreadPool::Team {
 public:
  explicit Team(uint32_t threads) : seats_(threads), arena_(static_cast<int>(threads)) {
    // TBB would quietly stop at the number of cores, or at what the first arena asked for.
    static const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                           kMaxThreads);
    if (threads <= std::thread::hardware_concurrency()) look_ = kLook;
  }
  ~Team() {
    Dismiss();
    arena_.execute([this] { called_.wait(); });
  }

  /// False if ForEach runs, in whose bodies this is.
  bool Run(Loop& loop, Helpers helpers) {
    if (busy_.test_and_set(std::memory_order_acquire)) return false;
    for (uint32_t share = 1; share < loop.shares(); ++share) {
      if (!seats_[share].Offer(loop) && helpers == Helpers::kAll) Call(share, loop);
    }
    loop.Work(0);
    for (uint32_t share = 1; share < loop.shares(); ++share) seats_[share].Withdraw();
    busy_.clear(std::memory_order_release);
    return true;
  }

  /// A loop in a body of ForEach: for threads that have nothing else to do.
  void RunBesideOthers(Loop& loop) {
    arena_.execute([&] {
      // While it waits for its last rows, a law must not be kept under another law that its thread
      // took up meanwhile.
      tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(
            uint32_t{0}, loop.shares(), [&](uint32_t share) { loop.Work(share); },
            tbb::static_partitioner());
      });
    });
  }

  void RunEach(uint64_t count, void (*body)(void* user, uint64_t i), void* user) {
    // Busy already: with a loop of a law's own thread, whose seats are not touched.
    const bool alone = !busy_.test_and_set(std::memory_order_acquire);
    if (alone) Dismiss();
    char begin = 0, end = 0;  // two points in time, for the thread sanitizer
    ComesBefore(&begin);
    const auto run = [&](uint64_t i) {
      ComesAfter(&begin);
      const FloatingPointGuard guard;
      body(user, i);
      ComesBefore(&end);
    };
    arena_.execute([&] {  // a task for each
      tbb::parallel_for(uint64_t{0}, count, run, tbb::simple_partitioner());
    });
    ComesAfter(&end);
    if (alone) busy_.clear(std::memory_order_release);
  }

 private:
  /// How long a thread looks for the next loop: longer than it takes from one to the next in a step
  /// of a small world, and no longer than the system takes to put it to sleep and to wake it.
  static constexpr std::chrono::microseconds kLook{50};

  void Call(uint32_t share, Loop& loop) {
    Seat& seat = seats_[share];
    seat.Leave(loop);
    try {
      arena_.enqueue(called_.defer([this, share, &seat] { seat.Help(share, look_); }));
    } catch (const std::bad_alloc&) {
      seat.Withdraw();
      seat.Dismiss();  // the others do its share
    }
  }

  void Dismiss() {
    for (Seat& seat : seats_) seat.Dismiss();
  }

  std::vector<Seat> seats_;  // of each share; the first belongs to the caller, who needs none
  std::atomic_flag busy_;
  Clock::duration look_{};  // none if there are more threads than processors
  tbb::task_arena arena_;
  tbb::task_group called_;
};

ThreadPool::ThreadPool(uint32_t threads) : threads_(threads) {
  if (threads > 1) team_ = std::make_unique<Team>(threads);
}

ThreadPool::~ThreadPool() = default;

void ThreadPool::ParallelFor(uint64_t count, uint64_t grain, RangeBody body, void* user,
                             Helpers helpers) {
  if (count == 0) return;
  if (grain == 0) grain = ChooseGrain(count);
  if (team_ != nullptr && count > grain) {
    Loop loop(count, grain, body, user, threads_);
    if (team_->Run(loop, helpers)) return;
    if (helpers == Helpers::kAll) return team_->RunBesideOthers(loop);
  }
  for (uint64_t begin = 0; begin < count; begin += grain) {
    body(user, begin, begin + std::min(grain, count - begin));
  }
}

void ThreadPool::RunEach(uint64_t count, void (*body)(void* user, uint64_t i), void* user) {
  if (team_ != nullptr && count > 1) return team_->RunEach(count, body, user);
  for (uint64_t i = 0; i < count; ++i) body(user, i);
}

}  // namespace vesper
