// SPDX-License-Identifier: Apache-2.0
// The engine's side of a sandbox: the process, the memory that the engine shares with it, and calls
// with a deadline.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "confinement.hpp"
#include "descriptor.hpp"
#include "exchange.hpp"

namespace vesper::apart {

/// Options for starting sandboxes.
struct Options {
  std::string program;  ///< path of vesper-sandbox
  uint64_t memory;      ///< limit of the private memory of each sandbox [bytes]
  bool incomplete;      ///< true: start it even if the system lacks a layer of protection
  std::chrono::milliseconds start{2000};  ///< limit of the time in which a sandbox starts
};

/// Memory that this process shares with a sandbox. This process can write to it; `seals` limit the
/// access of the sandbox.
class Segment {
 public:
  /// Creates a segment with `size` bytes in a window of reserved addresses.
  Segment(const char* name, uint64_t size, uint64_t window, int seals);
  ~Segment();
  Segment(const Segment&) = delete;
  Segment& operator=(const Segment&) = delete;

  int fd() const { return memory_.get(); }
  std::byte* data() const { return data_; }
  /// Makes the first `size` bytes usable; never shrinks. Throws Failure if the window is too small.
  void Grow(uint64_t size);

 private:
  Descriptor memory_;
  std::byte* data_ = nullptr;
  uint64_t size_;
  uint64_t window_;
};

/// Memory of a law in a segment; moved to the end of the segment when it must grow.
struct Region {
  uint64_t offset = 0;
  uint64_t capacity = 0;  // [bytes]
};

/// A running vesper-sandbox. Calls are made by one thread at a time.
class Sandbox {
 public:
  /// Starts the process with the bytes of a library. `library` names the library in messages.
  /// Throws Failure if the process cannot be started or lacks a layer of protection.
  Sandbox(const Options& options, std::span<const std::byte> bytes, const std::string& library);
  ~Sandbox();
  Sandbox(const Sandbox&) = delete;
  Sandbox& operator=(const Sandbox&) = delete;

  Exchange& exchange() { return *reinterpret_cast<Exchange*>(exchange_.data()); }
  std::byte* read() { return read_.data(); }
  std::byte* written() { return written_.data(); }
  /// Makes `region` of the read or the written segment at least `size` bytes long.
  void Reserve(bool written, Region& region, uint64_t size);
  /// Makes the sandbox execute a command, whose arguments are in the exchange. Throws LAW_CRASHED
  /// if the process ended, LAW_TIMED_OUT if it exceeded its time and was ended, or the Failure that
  /// the command returned. `limited`: the time of the call counts towards the limit of the frame.
  void Call(Command command, uint32_t law, bool limited);
  /// Returns false after a call that threw LAW_CRASHED or LAW_TIMED_OUT.
  bool IsAlive() const { return pid_ > 0; }
  /// Returns true if the signal SIGKILL ended the process. A law cannot send this signal to its own
  /// process, so the cause is outside of the sandbox, for example a lack of memory.
  bool WasKilled() const { return killed_; }
  const Layers& layers() const { return layers_; }

  /// Begins a frame of the engine in this process. All calls of one sandbox in this frame may
  /// together take the time `limit`, as processor time and idle time.
  static void BeginFrame(std::chrono::nanoseconds limit);

 private:
  using Nanoseconds = std::chrono::nanoseconds;

  void Start(const Options& options, int library_fd, const std::string& file,
             const std::string& library);
  void AwaitStart(int report, std::chrono::milliseconds limit);
  Nanoseconds Allowed(bool limited);
  void RequireRest();
  /// Waits for the reply. `limit` is the time in the message of LAW_TIMED_OUT.
  void Await(uint32_t number, Nanoseconds allowed, Nanoseconds limit);
  /// Returns true if the process has ended; then `status` is its wait status.
  bool HasEnded(int& status);
  /// Ends the process, and returns its wait status.
  int Kill();
  [[noreturn]] void ThrowCrashed(int status);
  Nanoseconds ProcessorTime() const;
  /// Returns the state of the process as a letter of proc(5), or 'S' if the system does not tell
  /// it.
  char State() const;
  /// Continues a process that a signal from outside has stopped, once in a frame. A law cannot stop
  /// its own process. Returns true if the process was continued.
  bool Continue();

  Segment exchange_;
  Segment read_;
  Segment written_;
  uint64_t read_end_ = 0;
  uint64_t written_end_ = 0;
  int pid_ = -1;
  Descriptor state_;  // /proc/…/stat
  Layers layers_;
  uint32_t requests_ = 0;
  bool quick_ = false;
  bool killed_ = false;
  uint64_t frame_ = 0;
  std::optional<uint64_t> continued_;  // the last frame in which the process was continued
  Nanoseconds spent_{0};               // time of the calls in this frame
  // Processor time at the begin of the last frame; time and number of the calls since then.
  Nanoseconds cpu_{0};
  Nanoseconds called_{0};
  uint64_t calls_ = 0;
  Nanoseconds busy_{0};  // processor time between calls, minus the time that waiting needs
};

}  // namespace vesper::apart
