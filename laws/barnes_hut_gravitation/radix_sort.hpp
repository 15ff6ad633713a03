// SPDX-License-Identifier: Apache-2.0
// A stable parallel sort of 64-bit keys.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace vesper::barnes_hut {

/// A row with its sort key.
struct Keyed {
  uint64_t key;
  uint32_t row;
};

/// Radix sort, least significant digit first, 8 bits at a time. Its memory is reused.
class RadixSort {
 public:
  /// Sorts items. `parallel(count, grain, body)` calls body(begin, end) for ranges of `grain` items
  /// that cover [0, count). Rows with equal keys keep their order.
  template <class Parallel>
  void operator()(const Parallel& parallel, std::span<Keyed> items) {
    if (spare_.size() < items.size()) spare_.resize(items.size());
    offsets_.resize((items.size() + kGrain - 1) / kGrain);
    std::span<Keyed> from = items, to(spare_.data(), items.size());
    for (int shift = 0; shift < 64; shift += kBits) {
      Count(parallel, from, shift);
      if (!MakeOffsets(items.size())) continue;
      Scatter(parallel, from, to, shift);
      std::swap(from, to);
    }
    if (from.data() != items.data()) std::ranges::copy(from, items.begin());
  }

 private:
  static constexpr int kBits = 8;
  static constexpr uint64_t kGrain = 16384;
  using Table = std::array<uint32_t, 1 << kBits>;

  static uint64_t Digit(const Keyed& item, int shift) {
    return (item.key >> shift) & ((1 << kBits) - 1);
  }

  template <class Parallel>
  void Count(const Parallel& parallel, std::span<const Keyed> from, int shift) {
    parallel(from.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      Table& counts = offsets_[begin / kGrain];
      counts.fill(0);
      for (const Keyed& item : from.subspan(begin, end - begin)) ++counts[Digit(item, shift)];
    });
  }

  /// Converts the counts of each digit to offsets in the result. Returns false if all items have
  /// the same digit.
  bool MakeOffsets(uint64_t items) {
    uint32_t place = 0;
    bool moves = true;
    for (uint64_t digit = 0; digit < std::tuple_size_v<Table>; ++digit) {
      const uint32_t start = place;
      for (Table& chunk : offsets_) place += std::exchange(chunk[digit], place);
      moves &= place - start != items;
    }
    return moves;
  }

  template <class Parallel>
  void Scatter(const Parallel& parallel, std::span<const Keyed> from, std::span<Keyed> to,
               int shift) {
    parallel(from.size(), kGrain, [&](uint64_t begin, uint64_t end) {
      Table& places = offsets_[begin / kGrain];
      for (const Keyed& item : from.subspan(begin, end - begin)) {
        to[places[Digit(item, shift)]++] = item;
      }
    });
  }

  std::vector<Keyed> spare_;
  std::vector<Table> offsets_;  // one per chunk
};

}  // namespace vesper::barnes_hut
