// SPDX-License-Identifier: Apache-2.0
#include "columns.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace vesper::host {
namespace {

size_t PageSize() {
  static const auto size = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  return size;
}

/// Returns the length of the address range that a mapping of `size` bytes reserves [bytes]. The
/// range consists of whole pages, and one guard page on each side.
size_t Reserved(uint64_t size) {
  const size_t page = PageSize();
  return (size + page - 1) / page * page + 2 * page;
}

[[noreturn]] void Fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

int Protection(bool writable) { return writable ? PROT_READ | PROT_WRITE : PROT_READ; }

}  // namespace

Mapping::Mapping(int client, uint32_t fd, uint64_t size, bool writable, uint64_t offset)
    : size_(size), lead_(offset % PageSize()), writable_(writable) {
  const std::string path = "/proc/" + std::to_string(client) + "/fd/" + std::to_string(fd);
  const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) Fail("opening the client's memory " + path);
  const size_t reserved = Reserved(lead_ + size);
  void* around =
      mmap(nullptr, reserved, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  void* memory = MAP_FAILED;
  if (around != MAP_FAILED) {
    memory = mmap(static_cast<std::byte*>(around) + PageSize(), lead_ + size, Protection(writable),
                  MAP_SHARED | MAP_FIXED, file, static_cast<off_t>(offset - lead_));
  }
  const int error = errno;
  close(file);
  errno = error;
  if (memory == MAP_FAILED) Fail("mapping " + std::to_string(size) + " bytes of the client");
  madvise(around, reserved, MADV_DONTFORK);
  data_ = static_cast<std::byte*>(memory) + lead_;
}

Mapping& Mapping::operator=(Mapping&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  std::swap(lead_, other.lead_);
  std::swap(writable_, other.writable_);
  return *this;
}

Mapping::~Mapping() {
  if (data_ != nullptr) munmap(data_ - lead_ - PageSize(), Reserved(lead_ + size_));
}

void Mapping::SetWritable(bool writable) {
  if (data_ == nullptr || writable == writable_) return;
  if (mprotect(data_ - lead_, lead_ + size_, Protection(writable)) != 0)
    Fail("protecting a column");
  writable_ = writable;
}

Columns::Arrays Columns::Replace(const std::string& property, Arrays arrays) {
  return std::exchange(arrays_[property], std::move(arrays));
}

const char* Columns::Find(const void* address, uint64_t& offset) const {
  const auto* at = static_cast<const std::byte*>(address);
  for (const auto& [property, arrays] : arrays_) {
    const std::byte* begin = arrays.data.data();
    if (begin == nullptr || at < begin || at >= begin + arrays.data.size()) continue;
    offset = static_cast<uint64_t>(at - begin);
    return property.c_str();
  }
  return nullptr;
}

void Columns::SetWritable(std::set<std::string> properties) {
  writable_ = std::move(properties);
  for (auto& [property, arrays] : arrays_) arrays.data.SetWritable(IsWritable(property));
}

}  // namespace vesper::host
