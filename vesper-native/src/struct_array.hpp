// Reading structs that begin with `struct_size` and may have been laid out by a newer caller.
#pragma once

#include <cstddef>
#include <cstdint>

#include "failure.hpp"

namespace vesper {

/// A larger stride than any future struct will have; catches uninitialised sizes.
inline constexpr uint32_t kMaxStructSize = 4096;

/// Refuses a struct that is smaller than this build knows (or than `minimum`, where later fields
/// may be missing), or of no plausible size.
template <class T>
void CheckStructSize(const T& item, const char* what, size_t minimum = sizeof(T)) {
  if (item.struct_size < minimum || item.struct_size > kMaxStructSize ||
      item.struct_size % alignof(T) != 0) {
    throw Failure(VESPER_INVALID_ARGUMENT, "%s.struct_size is %u, expected sizeof = %zu", what,
                  item.struct_size, sizeof(T));
  }
}

/// An array walked with the `struct_size` of its first element as stride.
template <class T>
class StructArray {
 public:
  StructArray(const T* first, uint32_t count, const char* what)
      : first_(reinterpret_cast<const std::byte*>(first)), count_(count) {
    if (count == 0) return;
    if (first == nullptr) throw Failure(VESPER_INVALID_ARGUMENT, "%s is null", what);
    CheckStructSize(*first, what);
    stride_ = first->struct_size;
    for (uint32_t i = 1; i < count; ++i) {
      if ((*this)[i].struct_size != stride_) {
        throw Failure(VESPER_INVALID_ARGUMENT, "%s[%u].struct_size is %u, expected %u as in [0]",
                      what, i, (*this)[i].struct_size, stride_);
      }
    }
  }

  uint32_t size() const { return count_; }
  const T& operator[](uint32_t i) const {
    return *reinterpret_cast<const T*>(first_ + size_t{i} * stride_);
  }

 private:
  const std::byte* first_;
  uint32_t count_;
  uint32_t stride_ = sizeof(T);
};

}  // namespace vesper
