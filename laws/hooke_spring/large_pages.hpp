// SPDX-License-Identifier: Apache-2.0
// Memory for arrays that are repeatedly read in sequence.
#pragma once

#include <sys/mman.h>

#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace vesper::hooke_spring {

/// Allocator that puts long arrays into large pages, if the system has large pages. With them, the
/// processor needs fewer address translations and can prefetch across longer ranges.
template <class T>
struct LargePages {
  using value_type = T;

  LargePages() = default;
  template <class Other>
  LargePages(const LargePages<Other>&) {}

  T* allocate(size_t count) {
    constexpr size_t kPage = size_t{1} << 21;
    if (count > (SIZE_MAX - kPage) / sizeof(T)) throw std::bad_alloc();
    const size_t alignment = count * sizeof(T) < kPage ? kLine : kPage;
    const size_t size = (count * sizeof(T) + alignment - 1) / alignment * alignment;
    void* memory = std::aligned_alloc(alignment, size);
    if (memory == nullptr) throw std::bad_alloc();
    if (alignment == kPage)
      madvise(memory, size, MADV_HUGEPAGE);  // if the kernel refuses,
                                             // small pages are used
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t) { std::free(memory); }

  template <class Other>
  bool operator==(const LargePages<Other>&) const {
    return true;
  }

 private:
  static constexpr size_t kLine = 64;
  static_assert(alignof(T) <= kLine);
};

template <class T>
using LargeArray = std::vector<T, LargePages<T>>;

}  // namespace vesper::hooke_spring
