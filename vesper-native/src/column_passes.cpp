// SPDX-License-Identifier: Apache-2.0
#include "column_passes.hpp"

#include <cstring>

#include "unit.hpp"

namespace vesper {

uint64_t FindNonFinite(ThreadPool& pool, vesper_scalar_type type, const void* values,
                       uint64_t count) {
  const auto* bytes = static_cast<const std::byte*>(values);
  return FindFirst(pool, count, [=](uint64_t begin, uint64_t end) {
    const uint64_t found = FindNonFinite(type, bytes + begin * ScalarSize(type), end - begin);
    return found == kNotFound ? kNotFound : begin + found;
  });
}

uint64_t FindImmense(ThreadPool& pool, vesper_scalar_type type, const void* values,
                     uint64_t count) {
  const auto* bytes = static_cast<const std::byte*>(values);
  return FindFirst(pool, count, [=](uint64_t begin, uint64_t end) {
    const uint64_t found = FindImmense(type, bytes + begin * ScalarSize(type), end - begin);
    return found == kNotFound ? kNotFound : begin + found;
  });
}

void Zero(ThreadPool& pool, vesper_scalar_type type, void* values, uint64_t count) {
  auto* bytes = static_cast<std::byte*>(values);
  auto clear = [=](uint64_t begin, uint64_t end) {
    std::memset(bytes + begin * ScalarSize(type), 0, (end - begin) * ScalarSize(type));
  };
  const Sharing sharing = ShareOut(count);
  pool.ParallelFor(count, sharing.grain, clear, sharing.helpers);
}

}  // namespace vesper
