// SPDX-License-Identifier: Apache-2.0
// Protects other processes from a host and the laws in it.
#pragma once

#include <cstdint>

namespace vesper::host {

/// Prepares this process for laws:
/// - It gets its own session, no core files, and a limit of private memory [bytes].
/// - The kernel's out-of-memory killer ends it before other processes.
/// - It ignores timer and termination signals.
void Isolate(uint64_t memory_limit);

/// Starts a thread that ends this process and its children as soon as the client process has ended.
void FollowClient(int client);

/// Calls `report` with the address of a memory fault, before the fault ends this process.
void ReportFaults(void (*report)(const void* address));

/// Returns the number of threads of this process.
uint32_t CountThreads();

}  // namespace vesper::host
