// SPDX-License-Identifier: Apache-2.0
// What the engine remembers for one law, row by row: a use with access SCRATCH.
#pragma once

#include <cstdint>

#include "aligned_buffer.hpp"

namespace vesper {

/// Rows of `row_size` bytes, zero until the law writes them.
class ScratchColumn {
 public:
  explicit ScratchColumn(size_t row_size = 0) : row_size_(row_size) {}

  /// Rows that stay keep their values, new ones are zero. May move the memory.
  void Resize(uint64_t row_count);
  /// Row `from` becomes row `to` <= `from`, and is itself as new. Rows beyond the end are as new.
  void MoveRow(uint64_t from, uint64_t to);
  /// Remembers all values, in memory that Resize made ready.
  void Keep();
  /// Takes the values back that were kept, in place.
  void Restore();

  std::byte* data() const { return values_.data(); }
  size_t row_size() const { return row_size_; }
  uint64_t row_count() const { return row_count_; }
  size_t byte_size() const { return row_count_ * row_size_; }

 private:
  size_t row_size_;
  uint64_t row_count_ = 0;
  AlignedBuffer values_;
  AlignedBuffer kept_;
};

}  // namespace vesper
