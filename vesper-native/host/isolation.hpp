// SPDX-License-Identifier: Apache-2.0
// Protects other processes from a host and the laws in it.
#pragma once

#include <cstdint>

namespace vesper::host {

/// Prepares this process for laws: a session of its own, no core files, a limit of private memory
/// [bytes], first candidate of the out-of-memory killer, timer and termination signals ignored.
void Isolate(uint64_t memory_limit);

/// Starts a thread that ends this process and its children as soon as the client process has ended.
void FollowClient(int client);

/// Calls `report` with the address of a memory fault, before the fault ends this process.
void ReportFaults(void (*report)(const void* address));

/// Returns the number of threads of this process.
uint32_t CountThreads();

}  // namespace vesper::host
