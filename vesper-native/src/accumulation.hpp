// SPDX-License-Identifier: Apache-2.0
// The sum of the additions of all laws to one property, such as a force.
#pragma once

#include <cstdint>
#include <vector>

#include "columns.hpp"
#include "law_library.hpp"
#include "thread_pool.hpp"

namespace vesper {

/// Total of an accumulator: its initial value plus the share of each law in load order.
class Accumulation {
 public:
  Accumulation(const Columns& columns, uint32_t property)
      : columns_(columns), property_(property) {}

  uint32_t property() const { return property_; }
  void AddShare(LoadedLaw& law, vesper_library_id library, MatchedUse& use) {
    shares_.push_back({&law, library, &use});
  }
  /// Returns true if the total starts from zero and only one law adds to it; this law then adds
  /// directly to the property's column.
  bool InPlace() const;
  /// Writes the total. If it is not finite, throws LAW_MISBEHAVED with the law whose share caused
  /// it, or INVALID_ARGUMENT if the initial value is not finite.
  void Sum(ThreadPool& pool) const;

 private:
  struct Share {
    LoadedLaw* law;
    vesper_library_id library;
    const MatchedUse* use;
  };

  const std::byte* Initial() const;
  /// Returns the index of the first value of the block that is not finite, or kNotFound.
  uint64_t SumBlock(uint64_t first, uint64_t count) const;
  [[noreturn]] void Blame(uint64_t value) const;

  const Columns& columns_;
  uint32_t property_;
  std::vector<Share> shares_;
};

}  // namespace vesper
