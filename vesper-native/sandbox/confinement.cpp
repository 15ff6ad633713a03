// SPDX-License-Identifier: Apache-2.0
#include "confinement.hpp"

#include <fcntl.h>
#include <grp.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <initializer_list>

#include "exchange.hpp"

namespace vesper::apart {
namespace {

constexpr uid_t kNobody = 65534;
constexpr uint64_t kLoadedBytes = uint64_t{256} << 20;  // size of programs and libraries
constexpr rlim_t kMaxDescriptors = 16;                  // while the library is loaded

/// The kernel's interface of Landlock. The headers of older distributions lack its newer fields.
struct LandlockRuleset {
  uint64_t handled_access_fs;
  uint64_t handled_access_net;
  uint64_t scoped;
};
struct [[gnu::packed]] LandlockPath {
  uint64_t allowed_access;
  int32_t parent_fd;
};
constexpr uint32_t kLandlockVersion = 1;
constexpr uint32_t kLandlockPathBeneath = 1;
constexpr uint64_t kLandlockReadFile = uint64_t{1} << 2;
#ifndef SYS_landlock_create_ruleset
#define SYS_landlock_create_ruleset 444
#define SYS_landlock_add_rule 445
#define SYS_landlock_restrict_self 446
#endif

void Note(Layers& layers, Layer layer, bool done) {
  if (!done) layers.error[layer] = errno != 0 ? errno : EPERM;
}

bool WriteFile(const char* path, const std::string& text) {
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  close(file);
  return written;
}

/// Enters a user namespace in which only this process's own user exists.
bool EnterUserNamespace() {
  const uid_t user = geteuid();
  const gid_t group = getegid();
  if (unshare(CLONE_NEWUSER) != 0) return false;
  WriteFile("/proc/self/setgroups", "deny");
  return WriteFile("/proc/self/uid_map", "0 " + std::to_string(user) + " 1") &&
         WriteFile("/proc/self/gid_map", "0 " + std::to_string(group) + " 1");
}

void Limit(__rlimit_resource resource, rlim_t value) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return;
  if (limit.rlim_max != RLIM_INFINITY && value > limit.rlim_max) value = limit.rlim_max;
  limit.rlim_cur = limit.rlim_max = value;
  setrlimit(resource, &limit);
}

bool WriteLibrary(const std::string& path, std::span<const std::byte> bytes) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0444);
  if (file < 0) return false;
  bool written = fchmod(file, 0444) == 0;  // whatever the umask is
  for (size_t done = 0; written && done < bytes.size();) {
    const ssize_t size = write(file, bytes.data() + done, bytes.size() - done);
    written = size > 0;
    if (written) done += static_cast<size_t>(size);
  }
  close(file);
  return written;
}

/// Makes a folder the root of all files of this process. A file system in memory is mounted on this
/// folder.
bool MakeRoot(const char* folder) {
  return chdir(folder) == 0 && syscall(SYS_pivot_root, ".", ".") == 0 &&
         umount2(".", MNT_DETACH) == 0 && chdir("/") == 0;
}

}  // namespace

const char* LayerName(Layer layer) {
  static constexpr const char* kNames[] = {
      "user namespace",  "process namespace", "network namespace", "IPC namespace",
      "mount namespace", "Landlock",          "seccomp filter"};
  static_assert(sizeof kNames / sizeof *kNames == kLayerCount);
  return layer < kLayerCount ? kNames[layer] : "?";
}

bool Layers::IsComplete() const {
  for (const int32_t refused : error) {
    if (refused != 0) return false;
  }
  return true;
}

std::string Layers::Missing() const {
  std::string text;
  for (uint32_t i = 0; i < kLayerCount; ++i) {
    if (error[i] == 0) continue;
    if (!text.empty()) text += ", ";
    text += LayerName(static_cast<Layer>(i));
    text += std::string(" (") + std::strerror(error[i]) + ")";
  }
  return text;
}

void EnterNamespaces(Layers& layers) {
  // Entering the other namespaces needs capabilities. Root has them, and enters the user namespace
  // last, in DropPrivileges. Users without these capabilities enter the user namespace first, and
  // get the capabilities from it.
  bool separated = geteuid() == 0 && unshare(CLONE_NEWPID) == 0;
  if (!separated) {
    Note(layers, kUserNamespace, EnterUserNamespace());
    separated = unshare(CLONE_NEWPID) == 0;
  }
  Note(layers, kPidNamespace, separated);
  Note(layers, kNetworkNamespace, unshare(CLONE_NEWNET) == 0);
  Note(layers, kIpcNamespace, unshare(CLONE_NEWIPC) == 0);
  Note(layers, kMountNamespace, unshare(CLONE_NEWNS) == 0);
  [[maybe_unused]] const int named = unshare(CLONE_NEWUTS | CLONE_NEWCGROUP);  // hides names only
}

std::string EnterEmptyRoot(std::span<const std::byte> bytes, const std::string& name,
                           Layers& layers) {
  static constexpr const char* kFolder = "/tmp";
  if (layers.error[kMountNamespace] != 0) return {};
  const std::string inside = std::string(kFolder) + "/" + name;
  const unsigned long flags = MS_NOSUID | MS_NODEV;
  const bool done =
      mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
      mount("law", kFolder, "tmpfs", flags, "size=80m,mode=0755") == 0 &&
      WriteLibrary(inside, bytes) &&
      mount(nullptr, kFolder, nullptr, MS_REMOUNT | MS_RDONLY | flags, nullptr) == 0 &&
      MakeRoot(kFolder);
  Note(layers, kMountNamespace, done);
  return done ? "/" + name : std::string();
}

void DropPrivileges(Layers& layers) {
  if (layers.error[kUserNamespace] == 0 && geteuid() == 0 && getuid() == 0) {
    // These calls fail if this process is already in a user namespace. The user id in such a
    // namespace is also 0, but this user has no rights outside of the namespace.
    const bool dropped = setgroups(0, nullptr) == 0 && setresgid(kNobody, kNobody, kNobody) == 0 &&
                         setresuid(kNobody, kNobody, kNobody) == 0;
    if (dropped) {
      prctl(PR_SET_DUMPABLE, 1);
      Note(layers, kUserNamespace, unshare(CLONE_NEWUSER) == 0);
    }
  }
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  const __user_cap_data_struct none[2] = {};
  syscall(SYS_capset, &header, none);
  prctl(PR_SET_DUMPABLE, 0);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
}

void LimitResources(uint64_t memory) {
  Limit(RLIMIT_AS, 2 * kSegmentWindow + kLoadedBytes + memory);
  Limit(RLIMIT_DATA, memory);
  Limit(RLIMIT_NOFILE, kMaxDescriptors);
  for (const __rlimit_resource resource : {RLIMIT_CORE, RLIMIT_FSIZE, RLIMIT_NPROC, RLIMIT_MEMLOCK,
                                           RLIMIT_MSGQUEUE, RLIMIT_RTPRIO, RLIMIT_SIGPENDING}) {
    Limit(resource, 0);
  }
}

void EnterLandlock(const std::string& path, Layers& layers) {
  const long version = syscall(SYS_landlock_create_ruleset, nullptr, size_t{0}, kLandlockVersion);
  if (version < 1) return Note(layers, kLandlock, false);
  const int rights = version >= 5 ? 16 : version >= 3 ? 15 : version >= 2 ? 14 : 13;
  LandlockRuleset ruleset{(uint64_t{1} << rights) - 1, 0, 0};
  size_t size = sizeof ruleset.handled_access_fs;
  if (version >= 4) {
    ruleset.handled_access_net = 3;  // bind and connect
    size = offsetof(LandlockRuleset, scoped);
  }
  if (version >= 6) {
    ruleset.scoped = 3;  // abstract sockets and signals
    size = sizeof ruleset;
  }
  const int rules =
      static_cast<int>(syscall(SYS_landlock_create_ruleset, &ruleset, size, uint32_t{0}));
  bool done = rules >= 0;
  if (done && !path.empty()) {
    const int file = open(path.c_str(), O_PATH | O_CLOEXEC);
    LandlockPath permitted{kLandlockReadFile, file};
    done = file >= 0 && syscall(SYS_landlock_add_rule, rules, kLandlockPathBeneath, &permitted,
                                uint32_t{0}) == 0;
    close(file);
  }
  done = done && syscall(SYS_landlock_restrict_self, rules, uint32_t{0}) == 0;
  Note(layers, kLandlock, done);
  if (rules >= 0) close(rules);
}

}  // namespace vesper::apart
