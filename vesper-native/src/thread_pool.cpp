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
#include "grain.hpp"
#include "thread_sanitizer.hpp"

namespace vesper {
namespace {

using Clock = std::chrono::steady_clock;

constexpr uint32_t kMaxThreads = 256;  // maximum number of threads of a process; at least that of a
                                       // config

/// Signals the processor that this thread busy-waits, so that the processor saves power.
inline void Pause() {
#if defined(__x86_64__)
  _mm_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// A wait for another thread. It is a busy-wait at first, and then yields the processor.
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

/** A loop whose chunks are divided into shares, one for each thread. A thread gets about the
 *  same rows in every loop, so that these rows stay in its processor's caches. Moving rows to
 *  another processor's cache takes about as long as a short loop. A thread therefore waits for a
 *  while before it takes chunks of a share that another thread has begun. */
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

  /// Runs the chunks that no thread has taken yet, starting with the thread's own share.
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

  /// The chunks of one thread. The constructor initialises nothing, because a loop may use only
  /// some of the shares.
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
  char begin_ = 0, end_ = 0;  // tags for the thread sanitizer
  std::array<Share, kMaxThreads> shares_;
};

/** The object through which a helper thread gets its next loop. The thread that runs a loop offers
 *  the loop to the helper, and withdraws the offer at the end. */
class alignas(64) Seat {
 public:
  /// Offers the loop to the helper. Returns true if the helper is waiting for a loop.
  bool Offer(Loop& loop) {
    loop_ = &loop;
    return Change(State::kFree, State::kOffered);
  }
  /// Stores the loop after Offer has returned false, for a helper that is being started.
  void Leave(Loop& loop) {
    loop_ = &loop;
    state_ = State::kOffered;
  }
  /// Ends the offer, so that a helper that has not begun the loop will not begin it. Returns when
  /// no helper works on the loop.
  void Withdraw() {
    if (Change(State::kOffered, State::kFree)) return;
    for (Wait wait; Is(State::kTaken);) wait.Moment();
  }
  /// Makes the helper leave, even if it is still starting. The caller must not call this between
  /// Offer and Withdraw.
  void Dismiss() { state_ = State::kAway; }

  /// Runs the helper, which works on this share of each offered loop. Waits up to `look` for the
  /// next loop.
  void Help(uint32_t share, Clock::duration look) {
    auto until = Clock::now() + look;
    for (; !Is(State::kAway); Pause()) {
      if (Is(State::kOffered) && Change(State::kOffered, State::kTaken)) {
        loop_->Work(share);
        state_ = State::kFree;
        until = Clock::now() + look;
      } else if (Clock::now() >= until) {
        // State kTaken means that this helper was dismissed and another helper has taken the loop.
        if (Change(State::kFree, State::kAway) || Is(State::kTaken)) return;
      }
    }
  }

 private:
  enum class State { kAway, kFree, kOffered, kTaken };

  bool Is(State state) const { return state_.load(std::memory_order_acquire) == state; }
  bool Change(State from, State to) { return state_.compare_exchange_strong(from, to); }

  std::atomic<State> state_ = State::kAway;
  Loop* loop_ = nullptr;  // written only while no helper can take it
};

}  // namespace

/** Helper threads, which belong to TBB. A helper stays awake for a short time after a loop and
 *  waits for the next loop. Therefore the short loops of a step need not wake the helper. */
class ThreadPool::Team {
 public:
  explicit Team(uint32_t threads) : seats_(threads), arena_(static_cast<int>(threads)) {
    // TBB by default limits its threads to the number of cores, or to the number that the first
    // arena requests. This limit permits more threads.
    static const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                           kMaxThreads);
    if (threads <= std::thread::hardware_concurrency()) look_ = kLook;
  }
  ~Team() {
    Dismiss();
    arena_.execute([this] { called_.wait(); });
  }

  /// Runs the loop. Returns false if it is called from a body of ForEach.
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

  /// Runs a loop from inside a body of ForEach, on threads that are idle.
  void RunBesideOthers(Loop& loop) {
    arena_.execute([&] {
      // The thread of a law that waits for the last chunks of its loop must not begin another law,
      // which would delay this law.
      tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(
            uint32_t{0}, loop.shares(), [&](uint32_t share) { loop.Work(share); },
            tbb::static_partitioner());
      });
    });
  }

  void RunEach(uint64_t count, void (*body)(void* user, uint64_t i), void* user) {
    // The flag `busy_` means that the thread of a law is running a loop. The seats of this loop
    // must not change.
    const bool alone = !busy_.test_and_set(std::memory_order_acquire);
    if (alone) Dismiss();
    char begin = 0, end = 0;  // tags for the thread sanitizer
    ComesBefore(&begin);
    const auto run = [&](uint64_t i) {
      ComesAfter(&begin);
      const FloatingPointGuard guard;
      body(user, i);
      ComesBefore(&end);
    };
    arena_.execute([&] {  // one task for each thread
      tbb::parallel_for(uint64_t{0}, count, run, tbb::simple_partitioner());
    });
    ComesAfter(&end);
    if (alone) busy_.clear(std::memory_order_release);
  }

 private:
  /// Time that a helper waits for the next loop before it sleeps. It is longer than the gap between
  /// two loops in a step of a small world. It does not exceed the time for putting a thread to
  /// sleep and waking it.
  static constexpr std::chrono::microseconds kLook{50};

  void Call(uint32_t share, Loop& loop) {
    Seat& seat = seats_[share];
    seat.Leave(loop);
    try {
      arena_.enqueue(called_.defer([this, share, &seat] { seat.Help(share, look_); }));
    } catch (const std::bad_alloc&) {
      seat.Withdraw();
      seat.Dismiss();  // no helper was started, so the other threads process its share
    }
  }

  void Dismiss() {
    for (Seat& seat : seats_) seat.Dismiss();
  }

  std::vector<Seat> seats_;  // one for each share; that of the caller's share is unused
  std::atomic_flag busy_;
  Clock::duration look_{};  // how long helpers wait; zero if there are more threads than processors
  tbb::task_arena arena_;
  tbb::task_group called_;
};

ThreadPool::ThreadPool(uint32_t threads) : threads_(threads) {
  if (threads > 1) team_ = std::make_unique<Team>(threads);
}

ThreadPool::~ThreadPool() = default;

uint32_t ThreadPool::this_thread() const {
  if (team_ == nullptr) return 0;
  const int index = tbb::this_task_arena::current_thread_index();
  return index < 0 || static_cast<uint32_t>(index) >= threads_ ? 0 : static_cast<uint32_t>(index);
}

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
