// SPDX-License-Identifier: Apache-2.0
// Memory whose blocks begin at cache lines.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace vesper::text {

/// Alignment, because storing a vector register across two cache lines is slow, and reading it back
/// stalls.
inline constexpr std::size_t kLine = 64;

template <class T>
struct LineAllocator {
  using value_type = T;
  LineAllocator() = default;
  template <class U>
  LineAllocator(const LineAllocator<U>&) {}
  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new(count * sizeof(T), std::align_val_t{kLine}));
  }
  void deallocate(T* memory, std::size_t count) {
    ::operator delete(memory, count * sizeof(T), std::align_val_t{kLine});
  }
  bool operator==(const LineAllocator&) const { return true; }
};

template <class T>
using LineVector = std::vector<T, LineAllocator<T>>;

}  // namespace vesper::text
