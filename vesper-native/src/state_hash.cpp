// SPDX-License-Identifier: Apache-2.0
#include "state_hash.hpp"

#include <xxhash.h>

#include <algorithm>

#include "kernels.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

constexpr uint64_t kBlock = 512;

void HashColumn(XXH3_state_t& state, const Columns& columns, uint32_t property) {
  const PropertySpec& spec = columns.spec(property);
  const size_t size = ScalarSize(spec.type);
  const uint64_t count = columns[property].arrays.row_count * spec.components;
  alignas(64) std::byte block[kBlock * sizeof(double)];
  for (uint64_t first = 0; first < count; first += kBlock) {
    const uint64_t length = std::min(kBlock, count - first);
    CopyCanonical(spec.type, block, columns[property].data() + first * size, length);
    XXH3_64bits_update(&state, block, length * size);
  }
}

}  // namespace

uint64_t HashState(uint64_t step_count, const Columns& columns) {
  XXH3_state_t state;
  XXH3_INITSTATE(&state);
  XXH3_64bits_reset(&state);
  XXH3_64bits_update(&state, &step_count, sizeof step_count);
  for (uint32_t property = 0; property < columns.size(); ++property) {
    if (columns[property].bound) HashColumn(state, columns, property);
  }
  return XXH3_64bits_digest(&state);
}

}  // namespace vesper
