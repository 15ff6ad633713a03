// SPDX-License-Identifier: Apache-2.0
// Memory of machine code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

namespace vesper::text {

/// Thrown if a program cannot become machine code; its evaluator then executes the program.
struct NoMachineCode {
  std::string reason;
};

/// Pages of machine code. They are writable, then executable, and never both.
class CodeMemory {
 public:
  CodeMemory() = default;
  /// Calls `write` with `size` bytes of writable memory, and makes the memory executable. Throws
  /// NoMachineCode if the operating system refuses.
  CodeMemory(size_t size, const std::function<void(uint8_t*)>& write);
  CodeMemory(CodeMemory&& other) noexcept { *this = std::move(other); }
  CodeMemory& operator=(CodeMemory&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~CodeMemory();

  uint8_t* data() const { return data_; }

 private:
  uint8_t* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace vesper::text
