// SPDX-License-Identifier: Apache-2.0
#include "accumulation.hpp"

#include <algorithm>
#include <cfloat>
#include <cinttypes>
#include <cmath>
#include <cstring>

#include "column_passes.hpp"
#include "failure.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

// Number of values in a block. The values of one block are summed at a time. The total of a block
// and the shares of the laws must fit into the first-level cache.
constexpr uint64_t kBlock = 1024;

}  // namespace

const std::byte* Accumulation::Initial() const {
  const uint32_t initial = columns_.spec(property_).initial_from;
  return initial != kNone && columns_[initial].bound ? columns_[initial].data() : nullptr;
}

bool Accumulation::InPlace() const { return shares_.size() == 1 && Initial() == nullptr; }

void Accumulation::Sum(ThreadPool& pool) const {
  if (InPlace()) return;
  const uint64_t count = columns_[property_].arrays.row_count * columns_.spec(property_).components;
  const uint64_t bad = FindFirst(pool, count, [this](uint64_t begin, uint64_t end) {
    for (uint64_t first = begin; first < end; first += kBlock) {
      const uint64_t found = SumBlock(first, std::min(kBlock, end - first));
      if (found != kNotFound) return found;
    }
    return kNotFound;
  });
  if (bad != kNotFound) Blame(bad);
}

uint64_t Accumulation::SumBlock(uint64_t first, uint64_t count) const {
  const vesper_scalar_type type = columns_.spec(property_).type;
  const size_t offset = first * ScalarSize(type);
  std::byte* total = columns_[property_].data() + offset;
  if (const std::byte* initial = Initial()) {
    std::memcpy(total, initial + offset, count * ScalarSize(type));
  } else {
    std::memset(total, 0, count * ScalarSize(type));
  }
  for (const Share& share : shares_) Add(type, total, share.use->share.data() + offset, count);
  const uint64_t bad = FindNonFinite(type, total, count);
  return bad == kNotFound ? kNotFound : first + bad;
}

void Accumulation::Blame(uint64_t value) const {
  const PropertySpec& spec = columns_.spec(property_);
  const uint64_t row = value / spec.components;
  const std::byte* initial = Initial();
  double total = initial != nullptr ? ValueAt(spec.type, initial, value) : 0;
  if (!std::isfinite(total)) {
    const std::string& name = columns_.spec(spec.initial_from).name;
    throw Failure(VESPER_INVALID_ARGUMENT, "property %s, row %" PRIu64 " is %g, expected a number",
                  name.c_str(), row, total)
        .Property(name)
        .Row(row);
  }
  const double largest = spec.type == VESPER_F32 ? FLT_MAX : DBL_MAX;
  const Share* culprit = &shares_.back();
  for (const Share& share : shares_) {
    total += ValueAt(spec.type, share.use->share.data(), value);
    if (std::abs(total) <= largest) continue;
    culprit = &share;
    break;
  }
  throw Failure(VESPER_LAW_MISBEHAVED,
                "%s: property %s, row %" PRIu64 ": what it adds makes the sum overflow",
                culprit->law->law.label().c_str(), spec.name.c_str(), row)
      .Library(culprit->library)
      .Law(culprit->law->index)
      .Property(spec.name)
      .Row(row);
}

}  // namespace vesper
