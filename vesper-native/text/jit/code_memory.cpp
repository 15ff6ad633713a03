// SPDX-License-Identifier: Apache-2.0
#include "code_memory.hpp"

#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace vesper::text {

CodeMemory::CodeMemory(size_t size, const std::function<void(uint8_t*)>& write) : size_(size) {
  void* pages = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (pages == MAP_FAILED) {
    throw NoMachineCode{std::string("no memory for machine code: ") + std::strerror(errno)};
  }
  data_ = static_cast<uint8_t*>(pages);
  write(data_);
  if (mprotect(pages, size, PROT_READ | PROT_EXEC) != 0) {
    const int error = errno;
    munmap(pages, size);
    throw NoMachineCode{std::string("the operating system refuses to execute generated code: ") +
                        std::strerror(error)};
  }
}

CodeMemory::~CodeMemory() {
  if (data_ != nullptr) munmap(data_, size_);
}

}  // namespace vesper::text
