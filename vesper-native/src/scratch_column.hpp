// SPDX-License-Identifier: Apache-2.0
// Memory that the engine keeps for one law, row by row: a use with access SCRATCH.
#pragma once

#include <cstdint>

#include "aligned_buffer.hpp"

namespace vesper {

/// Maximum memory of one use of SCRATCH, in all rows [bytes]; the engine keeps a copy besides.
inline constexpr uint64_t kMaxScratchBytes = uint64_t{1} << 30;

/// Scratch memory of a law: rows of `row_size` bytes, zero until the law writes them.
class ScratchColumn {
 public:
  explicit ScratchColumn(size_t row_size = 0) : row_size_(row_size) {}

  /// Changes the number of rows. Remaining rows keep their values, and new rows are zero. May move
  /// the memory.
  void Resize(uint64_t row_count);
  /// Moves row `from` to row `to` <= `from`, and zeroes row `from`. A row beyond the end counts as
  /// zero.
  void MoveRow(uint64_t from, uint64_t to);
  /// Stores a copy of all values, in memory that Resize has allocated.
  void Keep();
  /// Restores the stored values in place.
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
