// SPDX-License-Identifier: Apache-2.0
// The sum over laws of what they add to one property.
#pragma once

#include <cstdint>
#include <vector>

#include "columns.hpp"
#include "law_library.hpp"
#include "thread_pool.hpp"

namespace vesper {

/// Total of an accumulator: where it starts from, then each law's share in order of loading.
class Accumulation {
 public:
  Accumulation(const Columns& columns, uint32_t property)
      : columns_(columns), property_(property) {}

  uint32_t property() const { return property_; }
  void AddShare(LoadedLaw& law, vesper_library_id library, MatchedUse& use) {
    shares_.push_back({&law, library, &use});
  }
  /// Whether the total starts from zero and one law adds to it: then it adds in place.
  bool InPlace() const;
  /// Writes the total. Throws LAW_MISBEHAVED if it is not finite, naming the law whose share
  /// made it so, or INVALID_ARGUMENT if what it starts from is not.
  void Sum(ThreadPool& pool) const;

 private:
  struct Share {
    LoadedLaw* law;
    vesper_library_id library;
    const MatchedUse* use;
  };

  const std::byte* Initial() const;
  /// The first value of the block that is not finite, or kNotFound.
  uint64_t SumBlock(uint64_t first, uint64_t count) const;
  [[noreturn]] void Blame(uint64_t value) const;

  const Columns& columns_;
  uint32_t property_;
  std::vector<Share> shares_;
};

}  // namespace vesper
