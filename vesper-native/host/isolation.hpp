// SPDX-License-Identifier: Apache-2.0
// What keeps a host, and the laws in it, from harming other processes.
#pragma once

#include <cstdint>

namespace vesper::host {

/// Prepares this process for laws: its own session, no core files, a limit of private memory
/// [bytes], the first to be killed when memory is short, no timer or termination signals.
void Isolate(uint64_t memory_limit);

/// Starts a thread that ends this process and its children when the client has ended.
void FollowClient(int client);

/// Calls `report` with the address of a memory fault, before the fault ends this process.
void ReportFaults(void (*report)(const void* address));

/// Returns the number of threads of this process.
uint32_t CountThreads();

}  // namespace vesper::host
