// SPDX-License-Identifier: Apache-2.0
#include "probe_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <optional>
#include <vector>

#include "descriptor.hpp"
#include "failure.hpp"
#include "probe_report.hpp"

extern char** environ;

namespace vesper {
namespace {

using Clock = std::chrono::steady_clock;

const char* StageName(ProbeStage stage) {
  switch (stage) {
    case ProbeStage::kLoading:
      return "loading";
    case ProbeStage::kCallingEntry:
      return "calling " VESPER_LAW_LIBRARY_ENTRY;
    case ProbeStage::kReadingTable:
      return "reading its table";
    case ProbeStage::kUnloading:
      return "unloading";
    case ProbeStage::kDone:
      return "ending";
  }
  return "doing something unknown";
}

struct Pipe {
  Pipe() {
    int ends[2] = {-1, -1};
    const int result = pipe2(ends, O_CLOEXEC);
    read_end = Descriptor(result < 0 ? result : ends[0], "pipe for the probe");
    write_end = Descriptor(ends[1], "pipe for the probe");
  }
  Descriptor read_end;
  Descriptor write_end;
};

/// Duplicates a descriptor to a number above those of the probe. Therefore the setup of the probe's
/// descriptors does not overwrite it.
Descriptor DuplicateForProbe(int fd) {
  return Descriptor(fcntl(fd, F_DUPFD_CLOEXEC, kProbeReportFd + 1), "descriptor for the probe");
}

/// Descriptors and attributes of the probe process. It has default signal handling and its own
/// process group.
class SpawnSetup {
 public:
  SpawnSetup(int library, int report) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    for (int fd = 0; fd < 3; ++fd) {
      posix_spawn_file_actions_addopen(&actions_, fd, "/dev/null", O_RDWR, 0);
    }
    posix_spawn_file_actions_adddup2(&actions_, library, kProbeLibraryFd);
    posix_spawn_file_actions_adddup2(&actions_, report, kProbeReportFd);
    posix_spawn_file_actions_addclosefrom_np(&actions_, kProbeReportFd + 1);
    sigset_t signals;
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&attributes_, &signals);
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(
        &attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnSetup() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }
  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

/// Returns the environment of the probe. It contains only the variables of the dynamic loader,
/// because other variables may contain secrets.
std::vector<char*> LoaderEnvironment() {
  std::vector<char*> variables;
  for (char** variable = environ; variable != nullptr && *variable != nullptr; ++variable) {
    if (std::strncmp(*variable, "LD_", 3) == 0) variables.push_back(*variable);
  }
  variables.push_back(nullptr);
  return variables;
}

class Probe {
 public:
  Probe(const Config& config, const SealedCopy& copy) {
    Pipe pipe;
    const Descriptor library = DuplicateForProbe(copy.fd());
    const Descriptor report = DuplicateForProbe(pipe.write_end.get());
    pipe.write_end.Close();
    Start(config, copy, SpawnSetup(library.get(), report.get()));
    reports_ = std::move(pipe.read_end);
  }

  ~Probe() { End(); }

  /// Reads reports until the probe closes its end of the pipe, for example by a crash, or until the
  /// deadline.
  void Listen(Clock::time_point deadline) {
    for (;;) {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()).count();
      pollfd poll_fd{reports_.get(), POLLIN, 0};
      const int ready = poll(&poll_fd, 1, static_cast<int>(std::max<int64_t>(left, 0)));
      if (ready < 0 && errno == EINTR) continue;
      overran_ = ready <= 0;
      if (overran_) return;
      ProbeReport report;
      const ssize_t size = read(reports_.get(), &report, sizeof report);
      if (size < 0 && errno == EINTR) continue;
      if (size != sizeof report) return;
      last_ = report;
      Sanitize(last_.error);  // the library in the probe could have written to the pipe, too
    }
  }

  bool overran() const { return overran_; }
  const ProbeReport& last() const { return last_; }

  /// Kills the probe and its remaining children; returns its wait status if available.
  std::optional<int> End() {
    if (pid_ < 0) return status_;
    kill(-pid_, SIGKILL);
    int status = 0;
    pid_t ended;
    do {
      ended = waitpid(pid_, &status, 0);
    } while (ended < 0 && errno == EINTR);
    if (ended == pid_) status_ = status;
    pid_ = -1;
    return status_;
  }

 private:
  void Start(const Config& config, const SealedCopy& copy, const SpawnSetup& setup) {
    const std::string timeout = std::to_string(config.probe_timeout_ms);
    char* const arguments[] = {const_cast<char*>("vesper-probe"),
                               const_cast<char*>(copy.source().c_str()),
                               const_cast<char*>(timeout.c_str()), nullptr};
    pid_t pid = -1;
    const int error = posix_spawn(&pid, config.probe_path.c_str(), setup.actions(),
                                  setup.attributes(), arguments, LoaderEnvironment().data());
    if (error != 0) {
      throw Failure(VESPER_INTERNAL, "cannot start the probe %s: %s", config.probe_path.c_str(),
                    std::strerror(error));
    }
    pid_ = pid;
  }

  Descriptor reports_;
  pid_t pid_ = -1;
  bool overran_ = false;
  ProbeReport last_{ProbeStage::kLoading, BlankError()};
  std::optional<int> status_;
};

Failure LoadFailure(const SealedCopy& copy, const char* what, ProbeStage stage) {
  return Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: %s while %s", copy.source().c_str(), what,
                 StageName(stage));
}

}  // namespace

void ProbeLibrary(const Config& config, const SealedCopy& copy) {
  Probe probe(config, copy);
  probe.Listen(Clock::now() + std::chrono::milliseconds(config.probe_timeout_ms));
  const ProbeStage stage = probe.last().stage;
  if (probe.last().error.status != VESPER_OK) throw Failure(probe.last().error);
  if (probe.overran()) {
    const std::string what = "the library took more than " +
                             std::to_string(config.probe_timeout_ms) + " ms in the probe";
    throw LoadFailure(copy, what.c_str(), stage);
  }
  if (stage == ProbeStage::kDone) return;
  const std::optional<int> status = probe.End();
  if (status && WIFSIGNALED(*status) && WTERMSIG(*status) != SIGKILL) {
    const char* signal = sigabbrev_np(WTERMSIG(*status));
    const std::string what =
        "the library crashed the probe: SIG" + std::string(signal != nullptr ? signal : "?");
    throw LoadFailure(copy, what.c_str(), stage);
  }
  if (status && WIFEXITED(*status)) {
    const std::string what =
        "the library ended the probe with exit code " + std::to_string(WEXITSTATUS(*status));
    throw LoadFailure(copy, what.c_str(), stage);
  }
  throw LoadFailure(copy, "the library ended the probe", stage);
}

}  // namespace vesper
