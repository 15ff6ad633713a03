// SPDX-License-Identifier: Apache-2.0
// An engine-owned copy of a column with a canary (a known pattern) at both ends, to detect writes
// outside of it.
#pragma once

#include <cstddef>

#include "aligned_buffer.hpp"

namespace vesper {

class GuardedCopy {
 public:
  /// Makes room for `size` bytes and writes new canaries around them.
  void Resize(size_t size);

  std::byte* data() const { return buffer_.data() + kCanary; }
  bool FrontIntact() const;
  bool BackIntact() const;

 private:
  static constexpr size_t kCanary = 256;

  AlignedBuffer buffer_;
  size_t size_ = 0;
};

}  // namespace vesper
