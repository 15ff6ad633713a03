// SPDX-License-Identifier: Apache-2.0
#include "system_calls.hpp"

#include <seccomp.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <initializer_list>

namespace vesper::apart {
namespace {

/// System calls that every law needs: for memory, time, locks and the end of the process.
constexpr int kCommon[] = {
    SCMP_SYS(brk),          SCMP_SYS(munmap),         SCMP_SYS(mremap),
    SCMP_SYS(madvise),      SCMP_SYS(futex),          SCMP_SYS(getrandom),
    SCMP_SYS(sched_yield),  SCMP_SYS(clock_gettime),  SCMP_SYS(clock_getres),
    SCMP_SYS(gettimeofday), SCMP_SYS(time),           SCMP_SYS(clock_nanosleep),
    SCMP_SYS(nanosleep),    SCMP_SYS(getpid),         SCMP_SYS(gettid),
    SCMP_SYS(getcpu),       SCMP_SYS(getrusage),      SCMP_SYS(sched_getaffinity),
    SCMP_SYS(rt_sigreturn), SCMP_SYS(rt_sigprocmask), SCMP_SYS(restart_syscall),
    SCMP_SYS(exit),         SCMP_SYS(exit_group),
};

/// System calls that only the loader needs. Landlock and the empty root decide which files the
/// loader can open.
constexpr int kLoading[] = {
    SCMP_SYS(openat),     SCMP_SYS(read),   SCMP_SYS(pread64),     SCMP_SYS(fstat),
    SCMP_SYS(newfstatat), SCMP_SYS(close),  SCMP_SYS(close_range), SCMP_SYS(mmap),
    SCMP_SYS(mprotect),   SCMP_SYS(sendto), SCMP_SYS(recvfrom),    SCMP_SYS(seccomp),
};

/// System calls that libraries make to examine the system. These calls return an error, and the law
/// continues.
constexpr int kFailing[] = {
    SCMP_SYS(open),     SCMP_SYS(openat),     SCMP_SYS(openat2),   SCMP_SYS(creat),
    SCMP_SYS(stat),     SCMP_SYS(lstat),      SCMP_SYS(fstat),     SCMP_SYS(newfstatat),
    SCMP_SYS(statx),    SCMP_SYS(access),     SCMP_SYS(faccessat), SCMP_SYS(faccessat2),
    SCMP_SYS(readlink), SCMP_SYS(readlinkat), SCMP_SYS(getcwd),    SCMP_SYS(ioctl),
    SCMP_SYS(fcntl),    SCMP_SYS(read),       SCMP_SYS(pread64),   SCMP_SYS(readv),
    SCMP_SYS(write),    SCMP_SYS(pwrite64),   SCMP_SYS(writev),    SCMP_SYS(lseek),
    SCMP_SYS(close),    SCMP_SYS(uname),      SCMP_SYS(sysinfo),   SCMP_SYS(getuid),
    SCMP_SYS(geteuid),  SCMP_SYS(getgid),     SCMP_SYS(getegid),   SCMP_SYS(getppid),
};

bool Add(scmp_filter_ctx filter, std::initializer_list<scmp_arg_cmp> conditions, int call) {
  return seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, call,
                                static_cast<unsigned>(conditions.size()), conditions.begin()) == 0;
}

bool AddServing(scmp_filter_ctx filter) {
  // The filter permits these calls only for memory that is not executable.
  const auto data_only = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
  bool added =
      Add(filter, {data_only}, SCMP_SYS(mmap)) && Add(filter, {data_only}, SCMP_SYS(mprotect));
  for (const int call : kFailing) {
    added = added && seccomp_rule_add(filter, SCMP_ACT_ERRNO(EACCES), call, 0) == 0;
  }
  return added;
}

}  // namespace

int FilterCalls(Stage stage) {
  const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_TRAP);
  if (filter == nullptr) return ENOMEM;
  seccomp_attr_set(filter, SCMP_FLTATR_CTL_NNP, 0);  // no_new_privs is set already
  bool added = true;
  for (const int call : kCommon) added = added && Add(filter, {}, call);
  // The filter permits signals to the own process, because abort() sends SIGABRT to it.
  const auto self = static_cast<scmp_datum_t>(getpid());
  added = added && Add(filter, {SCMP_A0(SCMP_CMP_EQ, self), SCMP_A2(SCMP_CMP_EQ, SIGABRT)},
                       SCMP_SYS(tgkill));
  if (stage == Stage::kLoading) {
    for (const int call : kLoading) added = added && Add(filter, {}, call);
  } else {
    added = added && AddServing(filter);
  }
  const int loaded = added ? seccomp_load(filter) : -EINVAL;
  seccomp_release(filter);
  return loaded == 0 ? 0 : -loaded;
}

}  // namespace vesper::apart
