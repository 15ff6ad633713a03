// SPDX-License-Identifier: Apache-2.0
// Memory that the engine's process and a sandbox share: the exchange, the segment `read` for
// columns that the law reads, and the segment `written` for columns that it writes.
//
// The engine writes a command, raises `request` and wakes the sandbox. The sandbox sets `reply` to
// the same number when the command is done. The law can overwrite the exchange and the segment
// `written` at any time. Therefore the engine copies each value before it checks and uses it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "vesper/law.h"

namespace vesper::apart {

inline constexpr size_t kExchangeSize = size_t{1} << 20;
inline constexpr size_t kMailboxOffset = size_t{64} << 10;
inline constexpr size_t kMailboxSize = kExchangeSize - kMailboxOffset;
inline constexpr size_t kLogSize = size_t{32} << 10;
inline constexpr size_t kMaxLine = 1024;
/// Addresses reserved for each of the two segments [bytes].
inline constexpr uint64_t kSegmentWindow = uint64_t{64} << 30;

/// File descriptors with which a sandbox starts. The sandbox closes all of them before it accepts
/// commands.
enum StartDescriptor : int {
  kLibraryFd = 3,
  kExchangeFd,
  kReadFd,
  kWrittenFd,
  kReportFd,
  kEndOfDescriptors,
};

/// Commands of the engine to a sandbox. Their arguments and results are in the mailbox, except
/// those that have a field in Exchange.
enum class Command : uint32_t {
  kDescribe = 1,     ///< writes the table of the library
  kCreate,           ///< creates the law `law` from its parameters
  kBind,             ///< passes the law the positions of its arrays in the segments
  kAdvance,          ///< calls the law for `step`
  kPotentialEnergy,  ///< sets `energy`
};

struct Exchange {
  alignas(64) std::atomic<uint32_t> request;  // number of the newest request
  alignas(64) std::atomic<uint32_t> reply;    // number of the newest answered request
  alignas(64) Command command;
  uint32_t law;  // index in the table
  vesper_step step;
  alignas(64) vesper_status status;  // result of the command
  uint32_t refused_call;             // 1 + the system call that ended the sandbox, or 0
  double energy;                     // [J]
  vesper_error error;                // filled after a failure
  uint32_t log_used;                 // bytes of `log` that this request has filled
  uint32_t log_dropped;              // number of log lines that did not fit
  char log[kLogSize];  // for each line, its level and length (uint32_t each) and its text
};
static_assert(sizeof(Exchange) <= kMailboxOffset);

inline std::byte* Mailbox(Exchange& exchange) {
  return reinterpret_cast<std::byte*>(&exchange) + kMailboxOffset;
}

}  // namespace vesper::apart
