// SPDX-License-Identifier: Apache-2.0
// vesper-sandbox: runs the laws of one library in a process that can access only their columns.
//
// The engine's process starts it (see sandbox.cpp) with the descriptors of exchange.hpp. Its
// arguments are the limit of its memory [bytes], the file name of the library, and the name of the
// library in messages. `vesper-sandbox --check` prints which layers of protection this machine has.
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>

#include "confinement.hpp"
#include "control.hpp"
#include "exchange.hpp"
#include "failure.hpp"
#include "served_library.hpp"
#include "start_report.hpp"
#include "system_calls.hpp"

namespace {

using vesper::apart::Exchange;
using vesper::apart::Layers;

constexpr int kFirstSignal = 128;  // an exit code of this and more stands for a signal

Exchange* exchange = nullptr;

/// Handles two signals by ending this process. Without a handler, the kernel does not deliver these
/// signals to the first process of a process namespace.
void End(int number, siginfo_t* info, void*) {
  if (number == SIGSYS && exchange != nullptr) {
    exchange->refused_call = static_cast<uint32_t>(info->si_syscall) + 1;
  }
  _exit(kFirstSignal + number);
}

void CatchSignals() {
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (int number = 1; number < NSIG; ++number) signal(number, SIG_DFL);
  struct sigaction action{};
  action.sa_sigaction = End;
  action.sa_flags = SA_SIGINFO;
  for (const int number : {SIGSYS, SIGABRT}) sigaction(number, &action, nullptr);
}

std::byte* Map(int fd, uint64_t size, int protection) {
  void* memory = mmap(nullptr, size, protection, MAP_SHARED | MAP_NORESERVE, fd, 0);
  if (memory == MAP_FAILED) _exit(2);
  return static_cast<std::byte*>(memory);
}

/// Starts a child of the same parent, in the new process namespace. Returns as fork does.
long StartChild(unsigned long flags) {
  return syscall(SYS_clone, flags | SIGCHLD, nullptr, nullptr, nullptr, 0UL);
}

/// Reports the layers to the engine's process, and waits until it continues. Ends this process if
/// the engine's process has ended.
void Report(const Layers& layers) {
  const vesper::apart::StartReport report{0, layers};
  char go;
  if (send(vesper::apart::kReportFd, &report, sizeof report, MSG_NOSIGNAL) != sizeof report ||
      recv(vesper::apart::kReportFd, &go, 1, 0) != 1) {
    _exit(2);
  }
  close(vesper::apart::kReportFd);
}

void Confine(Layers& layers, const std::string& root_file, uint64_t memory) {
  vesper::apart::DropPrivileges(layers);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // set last, because a change of identity clears it
  vesper::apart::LimitResources(memory);
  vesper::apart::EnterLandlock(root_file, layers);
  layers.error[vesper::apart::kSeccomp] =
      vesper::apart::FilterCalls(vesper::apart::Stage::kLoading);
}

/// Opens the library. Then closes the last file descriptors and forbids the system calls that only
/// the loader needs.
void Open(vesper::apart::ServedLibrary& library, const std::string& path, const std::string& source,
          bool filtered) {
  try {
    library.Open(path, source);
  } catch (const vesper::Failure& failure) {
    library.Refuse(failure.error());
  }
  close_range(0, ~0U, 0);
  const int refused = vesper::apart::FilterCalls(vesper::apart::Stage::kServing);
  if (filtered && refused != 0) _exit(2);
}

[[noreturn]] void Serve(Layers layers, uint64_t memory, const std::string& file,
                        const std::string& source) {
  using namespace vesper::apart;
  exchange = reinterpret_cast<Exchange*>(Map(kExchangeFd, kExchangeSize, PROT_READ | PROT_WRITE));
  std::byte* read = Map(kReadFd, kSegmentWindow, PROT_READ);
  std::byte* written = Map(kWrittenFd, kSegmentWindow, PROT_READ | PROT_WRITE);
  struct stat status{};
  if (fstat(kLibraryFd, &status) != 0) _exit(2);
  const auto size = static_cast<size_t>(status.st_size);
  std::byte* bytes = Map(kLibraryFd, size, PROT_READ);
  const std::string root_file = EnterEmptyRoot(std::span(bytes, size), file, layers);
  munmap(bytes, size);
  CatchSignals();
  Confine(layers, root_file, memory);
  Report(layers);
  ServedLibrary library(*exchange, read, written);
  Open(library, root_file.empty() ? "/proc/self/fd/" + std::to_string(kLibraryFd) : root_file,
       source, layers.error[kSeccomp] == 0);
  vesper::host::Patience patience;
  for (uint32_t seen = 0;;) {
    seen = patience.AwaitChange(exchange->request, seen);
    library.Answer();
    vesper::host::Announce(exchange->reply, seen);
  }
}

/// Confines a child process like a process that serves a library, and prints the layers that
/// protect it.
int Check() {
  Layers layers;
  vesper::apart::EnterNamespaces(layers);
  std::fflush(nullptr);
  const long child = StartChild(0);
  if (child == 0) {
    const std::string root_file = vesper::apart::EnterEmptyRoot({}, "law.so", layers);
    vesper::apart::DropPrivileges(layers);
    vesper::apart::EnterLandlock(root_file, layers);
    std::string text;
    layers.error[vesper::apart::kSeccomp] = 0;
    for (uint32_t i = 0; i < vesper::apart::kLayerCount; ++i) {
      const bool filter = i == vesper::apart::kSeccomp;
      // The filter of system calls is set after this text is written, because the filter forbids
      // writing.
      const int refused = filter && prctl(PR_GET_SECCOMP) < 0 ? errno : layers.error[i];
      text += vesper::apart::LayerName(static_cast<vesper::apart::Layer>(i));
      text += refused == 0 ? std::string(": yes\n")
                           : ": no (" + std::string(std::strerror(refused)) + ")\n";
    }
    const bool complete = text.find(": no") == std::string::npos;
    const bool printed = write(1, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    const int filtered = vesper::apart::FilterCalls(vesper::apart::Stage::kLoading);
    _exit(complete && printed && filtered == 0 ? 0 : 1);
  }
  int status = 0;
  if (child < 0 || waitpid(static_cast<pid_t>(child), &status, 0) != child) return 2;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--check") == 0) return Check();
  if (argc != 4) {
    std::fprintf(stderr, "vesper-sandbox is started by vesper-host, not by hand\n");
    return 2;
  }
  Layers layers;
  vesper::apart::EnterNamespaces(layers);
  const long child = StartChild(CLONE_PARENT);
  if (child == 0) Serve(layers, std::strtoull(argv[1], nullptr, 10), argv[2], argv[3]);
  const vesper::apart::StartReport report{static_cast<int32_t>(child), {}};
  const bool sent =
      send(vesper::apart::kReportFd, &report, sizeof report, MSG_NOSIGNAL) == sizeof report;
  return child > 0 && sent ? 0 : 2;
}
