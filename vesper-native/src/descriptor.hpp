// SPDX-License-Identifier: Apache-2.0
// An open file descriptor, closed by its destructor.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "failure.hpp"

namespace vesper {

class Descriptor {
 public:
  Descriptor() = default;
  /// Takes ownership of a system call's result; if the call failed, throws with `what` and errno.
  Descriptor(int fd, const char* what) : fd_(fd) {
    if (fd < 0) throw Failure(VESPER_INTERNAL, "%s: %s", what, std::strerror(errno));
  }
  Descriptor(Descriptor&& other) noexcept : fd_(other.Release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() { Close(); }

  int get() const { return fd_; }
  int Release() { return std::exchange(fd_, -1); }
  void Close() {
    if (fd_ >= 0) close(Release());
  }

 private:
  int fd_ = -1;
};

}  // namespace vesper
