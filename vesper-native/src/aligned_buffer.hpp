// SPDX-License-Identifier: Apache-2.0
// Memory of columns that the engine owns.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <utility>

namespace vesper {

/// Bytes aligned to a cache line. The buffer grows and never shrinks, so steps with a constant
/// number of rows allocate nothing.
class AlignedBuffer {
 public:
  static constexpr size_t kAlignment = 64;

  AlignedBuffer() = default;
  /// Moves the buffer and leaves `other` empty.
  AlignedBuffer(AlignedBuffer&& other) noexcept
      : bytes_(std::move(other.bytes_)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  AlignedBuffer& operator=(AlignedBuffer&& other) noexcept {
    bytes_ = std::move(other.bytes_);
    size_ = std::exchange(other.size_, 0);
    capacity_ = std::exchange(other.capacity_, 0);
    return *this;
  }

  /// Makes room for `size` bytes. Their contents are unspecified if the buffer had to grow.
  void Resize(size_t size) {
    if (size > capacity_) {
      const size_t capacity = (size + kAlignment - 1) / kAlignment * kAlignment;
      bytes_.reset(static_cast<std::byte*>(std::aligned_alloc(kAlignment, capacity)));
      capacity_ = bytes_ ? capacity : 0;
      if (!bytes_) throw std::bad_alloc();
    }
    size_ = size;
  }

  std::byte* data() const { return bytes_.get(); }
  size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(std::byte* bytes) const { std::free(bytes); }
  };
  std::unique_ptr<std::byte[], Free> bytes_;
  size_t size_ = 0;
  size_t capacity_ = 0;
};

}  // namespace vesper
