// SPDX-License-Identifier: Apache-2.0
#include "scratch_column.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

namespace vesper {

void ScratchColumn::Resize(uint64_t row_count) {
  if (row_count == row_count_) return;
  if (row_count > INT64_MAX / row_size_) throw std::bad_alloc();
  const size_t stay = std::min(row_count, row_count_) * row_size_;
  const size_t size = row_count * row_size_;
  AlignedBuffer values, kept;
  values.Resize(size);
  kept.Resize(size);
  if (stay > 0) std::memcpy(values.data(), values_.data(), stay);
  if (size > stay) std::memset(values.data() + stay, 0, size - stay);
  values_ = std::move(values);
  kept_ = std::move(kept);
  row_count_ = row_count;
}

void ScratchColumn::MoveRow(uint64_t from, uint64_t to) {
  if (to >= row_count_) return;
  std::byte* target = values_.data() + to * row_size_;
  if (from >= row_count_) {
    std::memset(target, 0, row_size_);
    return;
  }
  std::byte* source = values_.data() + from * row_size_;
  if (from != to) std::memcpy(target, source, row_size_);
  std::memset(source, 0, row_size_);
}

void ScratchColumn::Keep() {
  if (row_count_ > 0) std::memcpy(kept_.data(), values_.data(), byte_size());
}

void ScratchColumn::Restore() {
  if (row_count_ > 0) std::memcpy(values_.data(), kept_.data(), byte_size());
}

}  // namespace vesper
