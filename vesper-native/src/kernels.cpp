// SPDX-License-Identifier: Apache-2.0
#include "kernels.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

// Compiles a second version of a function for CPUs with AVX2. The loader selects the version when
// the library is loaded. Each value is processed independently, so both versions give the same
// bits. Builds with sanitizers have one version only, because sanitizers cannot run code at that
// time.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VESPER_STREAMING [[gnu::target_clones("avx2", "default")]]
#else
#define VESPER_STREAMING
#endif

namespace vesper {
namespace {

// Number of values per block. It is large enough to vectorise, and small enough to stop soon after
// the first match.
constexpr uint64_t kBlock = 4096;

template <class Real>
struct Bits;
template <>
struct Bits<float> {
  using Type = uint32_t;
  static constexpr Type kExponent = 0x7f800000u, kOne = 0x00800000u, kTop = 0x80000000u;
  static constexpr Type kUnwritten = 0x7fe5be11u;
};
template <>
struct Bits<double> {
  using Type = uint64_t;
  static constexpr Type kExponent = 0x7ff0000000000000u, kOne = 0x0010000000000000u;
  static constexpr Type kTop = 0x8000000000000000u;
  static constexpr Type kImmense = kTop - (Type{1023 + 333} << 52);  // marks values from 2^333 on
  static constexpr Type kUnwritten = 0x7ffce5be11000000u;
};

template <class Real>
typename Bits<Real>::Type BitsAt(const void* values, uint64_t index) {
  typename Bits<Real>::Type bits;
  std::memcpy(&bits, static_cast<const std::byte*>(values) + index * sizeof bits, sizeof bits);
  return bits;
}

/// Returns the exponent bits plus `carry`. The sum sets the top bit (the mark) if the exponent is
/// so large that the addition carries into the sign bit.
template <class Real>
typename Bits<Real>::Type Mark(typename Bits<Real>::Type bits, typename Bits<Real>::Type carry) {
  return (bits & Bits<Real>::kExponent) + carry;
}

/// Returns the index of the first value with a mark, or kNotFound.
template <class Real>
uint64_t FindMarked(const void* values, uint64_t count, typename Bits<Real>::Type carry) {
  for (uint64_t begin = 0; begin < count; begin += kBlock) {
    const uint64_t end = std::min(count, begin + kBlock);
    typename Bits<Real>::Type marks = 0;
    for (uint64_t i = begin; i < end; ++i) marks |= Mark<Real>(BitsAt<Real>(values, i), carry);
    if ((marks & Bits<Real>::kTop) == 0) continue;
    for (uint64_t i = begin; i < end; ++i) {
      if ((Mark<Real>(BitsAt<Real>(values, i), carry) & Bits<Real>::kTop) != 0) return i;
    }
  }
  return kNotFound;
}

template <class Real>
void Add(void* sum, const void* addend, uint64_t count) {
  auto* to = static_cast<Real*>(sum);
  const auto* from = static_cast<const Real*>(addend);
  for (uint64_t i = 0; i < count; ++i) to[i] += from[i];
}

template <class Real>
void Convert(void* to, const void* from, UnitRatio ratio, uint64_t count) {
  auto* target = static_cast<Real*>(to);
  const auto* source = static_cast<const Real*>(from);
  for (uint64_t i = 0; i < count; ++i) {
    target[i] = static_cast<Real>(source[i] * ratio.multiply / ratio.divide);
  }
}

template <class Real>
void ConvertChanged(void* to, const void* from, const void* before, UnitRatio ratio,
                    uint64_t count) {
  auto* target = static_cast<Real*>(to);
  const auto* source = static_cast<const Real*>(from);
  for (uint64_t i = 0; i < count; ++i) {
    if (BitsAt<Real>(from, i) == BitsAt<Real>(before, i)) continue;
    target[i] = static_cast<Real>(source[i] * ratio.multiply / ratio.divide);
  }
}

template <class Real>
void CopyCanonical(void* to, const void* from, uint64_t count) {
  auto* target = static_cast<Real*>(to);
  const auto* source = static_cast<const Real*>(from);
  for (uint64_t i = 0; i < count; ++i) target[i] = source[i] + Real{0};
}

template <class Real>
void FillUnwritten(void* values, uint64_t count) {
  std::fill_n(static_cast<Real*>(values), count, std::bit_cast<Real>(Bits<Real>::kUnwritten));
}

template <class Real>
uint64_t FindBelow(const void* values, uint64_t count, double minimum) {
  const auto* begin = static_cast<const Real*>(values);
  const auto* end = begin + count;
  const auto* found = std::find_if(begin, end, [minimum](Real value) { return value < minimum; });
  return found == end ? kNotFound : static_cast<uint64_t>(found - begin);
}

}  // namespace

double ValueAt(vesper_scalar_type type, const void* values, uint64_t index) {
  if (type == VESPER_F32) return static_cast<const float*>(values)[index];
  return static_cast<const double*>(values)[index];
}

VESPER_STREAMING
uint64_t FindNonFinite(vesper_scalar_type type, const void* values, uint64_t count) {
  if (type == VESPER_F64) return FindMarked<double>(values, count, Bits<double>::kOne);
  if (type == VESPER_F32) return FindMarked<float>(values, count, Bits<float>::kOne);
  return kNotFound;
}

VESPER_STREAMING
uint64_t FindImmense(vesper_scalar_type type, const void* values, uint64_t count) {
  if (type == VESPER_F64) return FindMarked<double>(values, count, Bits<double>::kImmense);
  return FindNonFinite(type, values, count);
}

VESPER_STREAMING
void Add(vesper_scalar_type type, void* sum, const void* addend, uint64_t count) {
  if (type == VESPER_F64) Add<double>(sum, addend, count);
  if (type == VESPER_F32) Add<float>(sum, addend, count);
}

VESPER_STREAMING
void Convert(vesper_scalar_type type, void* to, const void* from, UnitRatio ratio, uint64_t count) {
  if (type == VESPER_F64) Convert<double>(to, from, ratio, count);
  if (type == VESPER_F32) Convert<float>(to, from, ratio, count);
}

void ConvertChanged(vesper_scalar_type type, void* to, const void* from, const void* before,
                    UnitRatio ratio, uint64_t count) {
  if (type == VESPER_F64) ConvertChanged<double>(to, from, before, ratio, count);
  if (type == VESPER_F32) ConvertChanged<float>(to, from, before, ratio, count);
}

void FillUnwritten(vesper_scalar_type type, void* values, uint64_t count) {
  if (type == VESPER_F64) FillUnwritten<double>(values, count);
  if (type == VESPER_F32) FillUnwritten<float>(values, count);
}

bool IsUnwritten(vesper_scalar_type type, const void* values, uint64_t index) {
  if (type == VESPER_F64) return BitsAt<double>(values, index) == Bits<double>::kUnwritten;
  if (type == VESPER_F32) return BitsAt<float>(values, index) == Bits<float>::kUnwritten;
  return false;
}

void CopyCanonical(vesper_scalar_type type, void* to, const void* from, uint64_t count) {
  if (type == VESPER_F64) return CopyCanonical<double>(to, from, count);
  if (type == VESPER_F32) return CopyCanonical<float>(to, from, count);
  std::memcpy(to, from, count * sizeof(uint32_t));
}

uint64_t FindOutOfRange(const uint32_t* values, uint64_t count, uint64_t limit) {
  const auto* end = values + count;
  const auto* found = std::find_if(values, end, [limit](uint32_t v) { return v >= limit; });
  return found == end ? kNotFound : static_cast<uint64_t>(found - values);
}

uint64_t FindBelow(vesper_scalar_type type, const void* values, uint64_t count, double minimum) {
  if (type == VESPER_F64) return FindBelow<double>(values, count, minimum);
  if (type == VESPER_F32) return FindBelow<float>(values, count, minimum);
  return kNotFound;
}

void Gather(void* to, const void* from, const uint32_t* indices, uint64_t count,
            uint64_t row_size) {
  auto* target = static_cast<std::byte*>(to);
  const auto* source = static_cast<const std::byte*>(from);
  for (uint64_t i = 0; i < count; ++i) {
    std::memcpy(target + i * row_size, source + uint64_t{indices[i]} * row_size, row_size);
  }
}

}  // namespace vesper
