// SPDX-License-Identifier: Apache-2.0
#include "scene_files.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "folders.hpp"

namespace vesper::cli {
namespace {

namespace fs = std::filesystem;

/// An open file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void Refuse(const std::string& name, const std::string& found) {
  throw std::runtime_error("'" + name + "' is " + found +
                           "; a scene reads only regular files in its own folder or below it: copy "
                           "the file there, or run the scene with --trust if you trust its author");
}

[[noreturn]] void FailToRead(const std::string& name, const std::error_code& error) {
  throw std::runtime_error("'" + name + "' cannot be read: " + error.message());
}

bool IsWithin(const fs::path& folder, const fs::path& file) {
  return std::ranges::mismatch(folder, file).in1 == folder.end();
}

/// Returns whether the file is a regular file on a disk. Returns false for files of the kernel,
/// such as those in /proc.
bool IsRegular(int fd) {
  struct stat file{};
  struct statfs system{};
  return fstat(fd, &file) == 0 && S_ISREG(file.st_mode) && fstatfs(fd, &system) == 0 &&
         system.f_type != PROC_SUPER_MAGIC && system.f_type != SYSFS_MAGIC;
}

}  // namespace

std::string SceneFiles::PathOf(const std::string& name) const { return FromFolderOf(scene_, name); }

std::string SceneFiles::Read(const std::string& name) const {
  return trusted_ ? ReadFile(PathOf(name)) : ReadWithin(name);
}

std::string SceneFiles::ReadWithin(const std::string& name) const {
  const fs::path path = name;
  if (path.is_absolute()) Refuse(name, "an absolute path");
  if (std::ranges::find(path, "..") != path.end()) Refuse(name, "a path with '..'");
  std::error_code error;
  const fs::path folder = fs::canonical(FromFolderOf(scene_, "."), error);
  const fs::path real = error ? fs::path() : fs::canonical(folder / path, error);
  if (error) FailToRead(name, error);
  if (!IsWithin(folder, real)) Refuse(name, "a link that leads out of the scene's folder");
  if (!fs::is_regular_file(fs::symlink_status(real, error))) Refuse(name, "not a regular file");
  const Descriptor file(open(real.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file.get() < 0) FailToRead(name, {errno, std::generic_category()});
  // The path of the opened file is checked again. Another process may have replaced the file, or a
  // folder on its path, since the first check.
  const std::string opened = "/proc/self/fd/" + std::to_string(file.get());
  if (fs::read_symlink(opened, error) != real || !IsRegular(file.get())) {
    Refuse(name, "not a regular file");
  }
  return ReadFile(opened, "'" + name + "'");
}

}  // namespace vesper::cli
