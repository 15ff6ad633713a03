// SPDX-License-Identifier: Apache-2.0
#include "sandbox.hpp"

#include <fcntl.h>
#include <linux/futex.h>
#include <poll.h>
#include <sched.h>
#include <seccomp.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <utility>

#include "control.hpp"
#include "failure.hpp"
#include "long_lived_thread.hpp"
#include "start_report.hpp"

namespace vesper::apart {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr milliseconds kRequestLimit{2000};  // time limit of calls outside of frames
constexpr nanoseconds kLook = milliseconds(1);
constexpr nanoseconds kAwake = std::chrono::microseconds(50);
/// Processor time that a sandbox may use between its calls, per frame and per call. A sandbox needs
/// such time because it begins each wait with a busy-wait.
constexpr nanoseconds kRestOfFrame = milliseconds(2);
constexpr nanoseconds kRestOfCall = std::chrono::microseconds(200);
/// Excess of processor time between calls, above the two limits, at which a sandbox is ended.
constexpr nanoseconds kTooBusy = milliseconds(200);
constexpr int kMostWall = 20;  // a call may last this multiple of its limit if it gets no processor
constexpr int kFirstSignal = 128;

std::atomic<uint64_t> frame_number = 0;
std::atomic<int64_t> frame_limit = nanoseconds(kRequestLimit).count();

/// Returns the file name that a library has inside its sandbox. The loader and debuggers show it.
std::string FileName(const std::string& library) {
  std::string name = library.substr(library.rfind('/') + 1).substr(0, 100);
  std::erase_if(name, [](char c) {
    return !std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-' && c != '.';
  });
  return name.empty() || name.front() == '.' ? "law.so" : name;
}

/// File descriptors and attributes of a starting sandbox. Its standard streams are closed, because
/// a law could write any amount of data to them.
class Setup {
 public:
  explicit Setup(const int (&descriptors)[5]) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawnattr_init(&attributes_);
    for (int fd = 0; fd < kLibraryFd; ++fd) {
      posix_spawn_file_actions_addopen(&actions_, fd, "/dev/null", O_RDWR, 0);
    }
    for (int i = 0; i < 5; ++i) {
      posix_spawn_file_actions_adddup2(&actions_, descriptors[i], kLibraryFd + i);
    }
    posix_spawn_file_actions_addclosefrom_np(&actions_, kEndOfDescriptors);
    sigset_t signals;
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&attributes_, &signals);
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~Setup() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }
  Setup(const Setup&) = delete;
  Setup& operator=(const Setup&) = delete;

  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

/// Duplicates a descriptor to a number above those of a starting sandbox. Therefore the setup of
/// the sandbox's descriptors does not overwrite it.
Descriptor Raised(int fd) {
  return Descriptor(fcntl(fd, F_DUPFD_CLOEXEC, kEndOfDescriptors), "descriptor for a sandbox");
}

Descriptor BytesFile(std::span<const std::byte> bytes) {
  Descriptor file(memfd_create("law library", MFD_CLOEXEC | MFD_ALLOW_SEALING),
                  "memory for a law library");
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t size = write(file.get(), bytes.data() + done, bytes.size() - done);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0)
      throw Failure(VESPER_INTERNAL, "copying a law library: %s", std::strerror(errno));
    done += static_cast<size_t>(size);
  }
  fcntl(file.get(), F_ADD_SEALS, F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE);
  return file;
}

int WaitFor(pid_t pid, int& status) {
  int ended;
  do {
    ended = waitpid(pid, &status, 0);
  } while (ended < 0 && errno == EINTR);
  return ended;
}

}  // namespace

Segment::Segment(const char* name, uint64_t size, uint64_t window, int seals)
    : memory_(memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING), "memory for a sandbox"),
      size_(size),
      window_(window) {
  if (ftruncate(fd(), static_cast<off_t>(size)) != 0) {
    throw Failure(VESPER_INTERNAL, "memory for a sandbox: %s", std::strerror(errno));
  }
  void* memory = mmap(nullptr, window, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_NORESERVE, fd(), 0);
  if (memory == MAP_FAILED || fcntl(fd(), F_ADD_SEALS, seals) != 0) {
    throw Failure(VESPER_INTERNAL, "memory for a sandbox: %s", std::strerror(errno));
  }
  madvise(memory, window, MADV_DONTFORK);
  data_ = static_cast<std::byte*>(memory);
}

Segment::~Segment() {
  if (data_ != nullptr) munmap(data_, window_);
}

void Segment::Grow(uint64_t size) {
  if (size <= size_) return;
  if (size > window_ || ftruncate(fd(), static_cast<off_t>(size)) != 0) {
    throw Failure(VESPER_INTERNAL,
                  "the columns of a sandboxed law need %" PRIu64 " bytes, at most %" PRIu64
                  " are available",
                  size, window_);
  }
  size_ = size;
}

void Sandbox::BeginFrame(nanoseconds limit) {
  frame_limit = limit.count();
  ++frame_number;
}

Sandbox::Sandbox(const Options& options, std::span<const std::byte> bytes,
                 const std::string& library)
    : exchange_("exchange with a law", kExchangeSize, kExchangeSize, F_SEAL_SHRINK | F_SEAL_GROW),
      read_("columns that a law reads", 0, kSegmentWindow, F_SEAL_SHRINK | F_SEAL_FUTURE_WRITE),
      written_("columns that a law writes", 0, kSegmentWindow, F_SEAL_SHRINK) {
  const Descriptor file = BytesFile(bytes);
  try {
    Start(options, file.get(), FileName(library), library);
    if (!layers_.IsComplete() && !options.incomplete) {
      throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: this machine lacks %s", library.c_str(),
                    layers_.Missing().c_str());
    }
  } catch (...) {
    Kill();
    throw;
  }
}

Sandbox::~Sandbox() { Kill(); }

void Sandbox::Start(const Options& options, int library_fd, const std::string& file,
                    const std::string& library) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
    throw Failure(VESPER_INTERNAL, "socket for a sandbox: %s", std::strerror(errno));
  }
  const Descriptor own(ends[0], "socket");
  Descriptor other(ends[1], "socket");
  const int given[] = {library_fd, exchange_.fd(), read_.fd(), written_.fd(), other.get()};
  Descriptor raised[5];
  int descriptors[5];
  for (int i = 0; i < 5; ++i) {
    raised[i] = Raised(given[i]);
    descriptors[i] = raised[i].get();
  }
  const Setup setup(descriptors);
  const std::string memory = std::to_string(options.memory);
  char* const arguments[] = {const_cast<char*>("vesper-sandbox"), const_cast<char*>(memory.c_str()),
                             const_cast<char*>(file.c_str()), const_cast<char*>(library.c_str()),
                             nullptr};
  char* const environment[] = {nullptr};
  pid_t starter = -1;
  // A sandbox ends with the thread that started it. Therefore a thread that lives as long as this
  // process starts the sandbox.
  const int error = LongLivedThread::Get().Run([&] {
    return posix_spawn(&starter, options.program.c_str(), setup.actions(), setup.attributes(),
                       arguments, environment);
  });
  if (error != 0) {
    throw Failure(VESPER_INTERNAL, "cannot start the sandbox %s: %s", options.program.c_str(),
                  std::strerror(error));
  }
  other.Close();
  for (Descriptor& descriptor : raised) descriptor.Close();
  AwaitStart(own.get(), options.start);
  int status = 0;
  WaitFor(starter, status);
  const std::string path = "/proc/" + std::to_string(pid_) + "/stat";
  const int opened = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened >= 0) state_ = Descriptor(opened, "state of a sandbox");
  if (send(own.get(), "", 1, MSG_NOSIGNAL) != 1) {
    throw Failure(VESPER_INTERNAL, "the sandbox ended while it started");
  }
  cpu_ = ProcessorTime();
}

/// Waits until the process that starts the sandbox has reported the sandbox's process id, and the
/// sandbox has reported which layers of protection are active.
void Sandbox::AwaitStart(int report, milliseconds limit) {
  const auto deadline = Clock::now() + limit;
  for (bool confined = false; pid_ < 0 || !confined;) {
    const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now()).count();
    pollfd poll_fd{report, POLLIN, 0};
    const int ready = poll(&poll_fd, 1, static_cast<int>(std::max<int64_t>(left, 0)));
    if (ready < 0 && errno == EINTR) continue;
    StartReport message{};
    if (ready <= 0 || recv(report, &message, sizeof message, 0) != sizeof message ||
        message.process < 0) {
      throw Failure(VESPER_INTERNAL, "the sandbox did not start within %d ms",
                    static_cast<int>(limit.count()));
    }
    if (message.process > 0) {
      pid_ = message.process;
    } else {
      layers_ = message.layers;
      confined = true;
    }
  }
}

void Sandbox::Reserve(bool written, Region& region, uint64_t size) {
  if (size <= region.capacity) return;
  uint64_t& end = written ? written_end_ : read_end_;
  const uint64_t capacity = std::max(size, 2 * region.capacity);
  (written ? written_ : read_).Grow(end + capacity);
  region = {end, capacity};
  end += capacity;
}

nanoseconds Sandbox::Allowed(bool limited) {
  if (!limited) return kRequestLimit;
  if (frame_ != frame_number) {
    frame_ = frame_number;
    spent_ = nanoseconds(0);
    RequireRest();
  }
  return nanoseconds(frame_limit) - spent_;
}

/// Ends a sandbox that uses too much processor time between its calls. A law that takes control of
/// its process could otherwise use a processor for ever, even in a paused world.
void Sandbox::RequireRest() {
  const nanoseconds cpu = ProcessorTime();
  const nanoseconds rest = kRestOfFrame + static_cast<int64_t>(calls_) * kRestOfCall;
  busy_ = std::max(busy_ + (cpu - cpu_) - called_ - rest, nanoseconds(0));
  cpu_ = cpu;
  called_ = nanoseconds(0);
  calls_ = 0;
  if (busy_ < kTooBusy) return;
  Kill();
  throw Failure(VESPER_LAW_TIMED_OUT,
                "used %" PRId64 " ms of processor time between its calls, expected none",
                std::chrono::duration_cast<milliseconds>(busy_).count());
}

void Sandbox::Call(Command command, uint32_t law, bool limited) {
  exchange().command = command;
  exchange().law = law;
  const nanoseconds allowed = Allowed(limited);
  const auto start = Clock::now();
  const uint32_t number = ++requests_;
  host::Announce(exchange().request, number);
  while (quick_ && exchange().reply.load(std::memory_order_acquire) != number &&
         Clock::now() - start < kAwake) {
    sched_yield();
  }
  if (exchange().reply.load(std::memory_order_acquire) != number)
    Await(number, allowed, limited ? nanoseconds(frame_limit) : kRequestLimit);
  const auto took = Clock::now() - start;
  quick_ = took < 2 * kAwake;
  spent_ += took;
  called_ += took;
  ++calls_;
  if (exchange().status == VESPER_OK) return;
  vesper_error error = exchange().error;
  error.status = VESPER_LAW_FAILED;
  Sanitize(error);
  throw Failure(error);
}

void Sandbox::Await(uint32_t number, nanoseconds allowed, nanoseconds limit) {
  const auto start = Clock::now();
  const nanoseconds start_cpu = ProcessorTime();
  nanoseconds cpu = start_cpu, idle{0};
  for (auto last = start;;) {
    const uint32_t seen = exchange().reply.load(std::memory_order_acquire);
    if (seen == number) return;
    const timespec look{0, kLook.count()};
    syscall(SYS_futex, &exchange().reply, FUTEX_WAIT, seen, &look, nullptr, 0);
    if (exchange().reply.load(std::memory_order_acquire) == number) return;
    int status = 0;
    if (HasEnded(status)) ThrowCrashed(status);
    const auto now = Clock::now();
    const nanoseconds before = std::exchange(cpu, std::max(cpu, ProcessorTime()));
    // Only time in which the process sleeps or is stopped counts as idle. A process that waits for
    // a processor is not idle.
    if (!Continue() && cpu - before < kLook / 10 && std::strchr("STt", State()) != nullptr) {
      idle += std::min(now - last, 5 * kLook);
    }
    last = now;
    const nanoseconds wall = now - start;
    if (std::min(cpu - start_cpu + idle, wall) < allowed && wall < kMostWall * allowed) continue;
    // The way in which the process ended is checked, because it may have ended by itself meanwhile.
    if (const int ended = Kill(); !WIFSIGNALED(ended) || WTERMSIG(ended) != SIGKILL) {
      ThrowCrashed(ended);
    }
    throw Failure(VESPER_LAW_TIMED_OUT, "no answer within %" PRId64 " ms",
                  std::chrono::duration_cast<milliseconds>(limit).count());
  }
}

bool Sandbox::HasEnded(int& status) {
  const pid_t ended = waitpid(pid_, &status, WNOHANG);
  if (ended == 0) return false;
  pid_ = -1;
  return true;
}

void Sandbox::ThrowCrashed(int status) {
  int number = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (WIFEXITED(status) && WEXITSTATUS(status) > kFirstSignal) {
    number = WEXITSTATUS(status) - kFirstSignal;
  }
  const uint32_t refused = exchange().refused_call;
  if (number == SIGSYS && refused != 0) {
    char* name = seccomp_syscall_resolve_num_arch(SCMP_ARCH_NATIVE, static_cast<int>(refused - 1));
    const std::string call = name != nullptr ? name : std::to_string(refused - 1);
    std::free(name);
    throw Failure(VESPER_LAW_CRASHED, "made the system call %s, which its sandbox does not permit",
                  call.c_str());
  }
  killed_ = WIFSIGNALED(status) && number == SIGKILL;
  if (number != 0) {
    const char* signal = sigabbrev_np(number);
    throw Failure(VESPER_LAW_CRASHED, "ended its process: SIG%s", signal != nullptr ? signal : "?");
  }
  throw Failure(VESPER_LAW_CRASHED, "ended its process: exit code %d", WEXITSTATUS(status));
}

nanoseconds Sandbox::ProcessorTime() const {
  constexpr int kScheduler = 2;  // clock of the processor time of a process
  const auto clock = static_cast<clockid_t>((~static_cast<unsigned>(pid_) << 3) | kScheduler);
  timespec time{};
  if (clock_gettime(clock, &time) != 0) return nanoseconds(0);
  return std::chrono::seconds(time.tv_sec) + nanoseconds(time.tv_nsec);
}

char Sandbox::State() const {
  char text[256];
  const ssize_t size = state_.get() < 0 ? -1 : pread(state_.get(), text, sizeof text - 1, 0);
  if (size <= 0) return state_.get() < 0 ? 'S' : 'X';
  text[size] = '\0';
  const char* name_end = std::strrchr(text, ')');
  return name_end != nullptr && name_end[1] == ' ' ? name_end[2] : 'X';
}

bool Sandbox::Continue() {
  const uint64_t frame = frame_number;
  if (continued_ == frame || State() != 'T') return false;
  continued_ = frame;
  return kill(pid_, SIGCONT) == 0;
}

int Sandbox::Kill() {
  int status = 0;
  if (pid_ <= 0) return status;
  kill(pid_, SIGKILL);
  WaitFor(pid_, status);
  pid_ = -1;
  return status;
}

}  // namespace vesper::apart
