// SPDX-License-Identifier: Apache-2.0
// vesper-host: a physics engine in a process of its own.
//
// Its arguments are the process id of the client, the client's descriptor of the shared memory (see
// control.hpp), and the limit of the host's private memory [bytes]. The engine uses the client's
// columns in place. The host ends when its client ends, and stores no data anywhere else.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "columns.hpp"
#include "control.hpp"
#include "isolation.hpp"
#include "law_apart.hpp"
#include "service.hpp"

namespace {

vesper::host::Service* served = nullptr;

void Serve(int client, uint32_t descriptor, uint64_t memory_limit) {
  const vesper::host::Mapping memory(client, descriptor, vesper::host::kControlSize, true);
  auto& control = *reinterpret_cast<vesper::host::Control*>(memory.data());
  control.magic = vesper::host::kMagic;
  vesper::host::Service service(client, control, memory_limit);
  served = &service;
  vesper::host::ReportFaults([](const void* address) { served->NoteFault(address); });
  vesper::host::Patience patience;
  for (uint32_t seen = 0;;) {
    seen = patience.AwaitChange(control.request, seen);
    service.Answer();
    vesper::host::Announce(control.reply, seen);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "vesper-host is started by a client of the engine, not by hand\n");
    return 2;
  }
  const int client = std::atoi(argv[1]);
  const uint64_t memory_limit = std::strtoull(argv[3], nullptr, 10);
  vesper::host::Isolate(memory_limit);
  vesper::host::FollowClient(client);
  try {
    vesper::apart::Prepare();
    Serve(client, static_cast<uint32_t>(std::strtoul(argv[2], nullptr, 10)), memory_limit);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "vesper-host: %s\n", failure.what());
    return 1;
  }
}
