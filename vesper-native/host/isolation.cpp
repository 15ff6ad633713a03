// SPDX-License-Identifier: Apache-2.0
#include "isolation.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <initializer_list>
#include <thread>

namespace vesper::host {
namespace {

constexpr std::chrono::milliseconds kLook{100};

/// Makes the kernel end this process before other processes when memory is exhausted.
void OfferToOutOfMemoryKiller() {
  const int file = open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (file < 0) return;
  [[maybe_unused]] const ssize_t written = write(file, "1000", 4);
  close(file);
}

void Limit(__rlimit_resource resource, uint64_t value) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return;
  if (limit.rlim_max != RLIM_INFINITY && value > limit.rlim_max) value = limit.rlim_max;
  limit.rlim_cur = limit.rlim_max = value;
  setrlimit(resource, &limit);
}

}  // namespace

void Isolate(uint64_t memory_limit) {
  setsid();
  umask(077);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  Limit(RLIMIT_CORE, 0);
  if (memory_limit > 0) Limit(RLIMIT_DATA, memory_limit);
  OfferToOutOfMemoryKiller();
  // Ignores these signals, because a law that sets a timer or sends a signal to its own process
  // must not end the process while another law runs.
  for (const int signal : {SIGALRM, SIGVTALRM, SIGPROF, SIGTERM, SIGHUP, SIGINT, SIGPIPE, SIGQUIT,
                           SIGUSR1, SIGUSR2, SIGTSTP, SIGTTIN, SIGTTOU}) {
    ::signal(signal, SIG_IGN);
  }
}

void FollowClient(int client) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread([client] {
    while (getppid() == client) std::this_thread::sleep_for(kLook);
    kill(0, SIGKILL);  // ends the whole process group, which contains this process
    _exit(0);
  }).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

namespace {

void (*report_fault)(const void* address);

/// Reports a memory fault. When this handler returns, the fault occurs again, and the default
/// action ends the process with the same signal.
void OnFault(int number, siginfo_t* info, void*) {
  report_fault(info->si_addr);
  signal(number, SIG_DFL);
}

}  // namespace

void ReportFaults(void (*report)(const void* address)) {
  static std::byte stack[1 << 16];  // separate, because the law may have exhausted the thread's own
                                    // stack
  report_fault = report;
  stack_t alternate{};
  alternate.ss_sp = stack;
  alternate.ss_size = sizeof stack;
  sigaltstack(&alternate, nullptr);
  struct sigaction action{};
  action.sa_sigaction = OnFault;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigaction(SIGSEGV, &action, nullptr);
}

uint32_t CountThreads() {
  DIR* tasks = opendir("/proc/self/task");
  if (tasks == nullptr) return 0;
  uint32_t count = 0;
  while (const dirent* task = readdir(tasks)) {
    if (task->d_name[0] != '.') ++count;
  }
  closedir(tasks);
  return count;
}

}  // namespace vesper::host
