// SPDX-License-Identifier: Apache-2.0
// The memory that a host (a process with an engine) shares with its client, and the functions with
// which the two processes wait for each other.
//
// The client writes a request into the mailbox, raises `request` and wakes the host. The host
// writes the reply into the mailbox, sets `reply` to the same number and wakes the client. Only one
// of the two may use the mailbox at a time. The client's side is reve.pe.hosted.HostProcess in
// Java, with the same offsets.
#pragma once

#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace vesper::host {

inline constexpr uint32_t kMagic = 0x31484F56;  // "VOH1", little-endian
inline constexpr uint32_t kMaxThreads = 256;    // limit of vesper_engine_config.threads
inline constexpr size_t kControlSize = size_t{1} << 20;
inline constexpr size_t kLogSize = 60 << 10;
inline constexpr size_t kMailboxOffset = size_t{64} << 10;
inline constexpr size_t kMailboxSize = kControlSize - kMailboxOffset;

/// The first part of the shared memory; the mailbox follows at kMailboxOffset.
struct Control {
  uint32_t magic;
  alignas(64) std::atomic<uint32_t> request;  // number of the newest request
  alignas(64) std::atomic<uint32_t> reply;    // number of the newest answered request
  alignas(64) uint64_t running[kMaxThreads];  // law that each thread calls (vesper_engine_config)
  alignas(64) char wrote[56];                 // read-only property whose write caused the crash
  uint64_t wrote_offset;                      // offset of that write in its column [bytes]
  alignas(64) uint32_t log_used;              // bytes of `log` that this request has filled
  uint32_t log_dropped;                       // number of log lines that did not fit
  char log[kLogSize];  // for each line, its level and length (uint32_t each) and its text
};
static_assert(sizeof(Control) <= kMailboxOffset);
static_assert(offsetof(Control, request) == 64 && offsetof(Control, reply) == 128 &&
              offsetof(Control, running) == 192 && offsetof(Control, wrote) == 2240 &&
              offsetof(Control, wrote_offset) == 2296 && offsetof(Control, log_used) == 2304 &&
              offsetof(Control, log) == 2312);

inline std::byte* Mailbox(Control& control) {
  return reinterpret_cast<std::byte*>(&control) + kMailboxOffset;
}

/// Waits for changes of a word. If the previous wait was short, the next wait begins with a
/// busy-wait, because waking this process takes longer than most frames. During the busy-wait,
/// other processes may use the processor. After a long wait (the client's world waits for the
/// clock), the process sleeps at once.
class Patience {
 public:
  /// Waits until the word is different from `seen`; returns its value.
  uint32_t AwaitChange(std::atomic<uint32_t>& word, uint32_t seen) {
    const auto begin = Clock::now();
    uint32_t now = word.load(std::memory_order_acquire);
    while (quick_ && now == seen && Clock::now() - begin < kAwake) {
      sched_yield();
      now = word.load(std::memory_order_acquire);
    }
    for (; now == seen; now = word.load(std::memory_order_acquire)) {
      syscall(SYS_futex, &word, FUTEX_WAIT, seen, nullptr, nullptr, 0);
    }
    quick_ = Clock::now() - begin < kQuick;
    return now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kAwake = std::chrono::microseconds(100);
  static constexpr auto kQuick = std::chrono::microseconds(200);

  bool quick_ = false;
};

/// Sets the word and wakes the process that waits for it.
inline void Announce(std::atomic<uint32_t>& word, uint32_t value) {
  word.store(value, std::memory_order_release);
  syscall(SYS_futex, &word, FUTEX_WAKE, 1, nullptr, nullptr, 0);
}

}  // namespace vesper::host
