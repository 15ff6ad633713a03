// SPDX-License-Identifier: Apache-2.0
// Conversion of structs that begin with `struct_size` between minor versions of the contract.
// Fields are only appended, and a missing field counts as zero.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "failure.hpp"
#include "vesper/engine.h"
#include "vesper/law.h"

namespace vesper {

/// Minimum size of the struct [bytes]. It is the size of the struct in the first version of the
/// contract that contains it. These numbers never change.
template <class T>
inline constexpr uint32_t kFirstSize = 0;
template <>
inline constexpr uint32_t kFirstSize<vesper_parameter> = 24;
template <>
inline constexpr uint32_t kFirstSize<vesper_field> = 24;
template <>
inline constexpr uint32_t kFirstSize<vesper_property_descriptor> = 88;
template <>
inline constexpr uint32_t kFirstSize<vesper_prototype> = 64;
template <>
inline constexpr uint32_t kFirstSize<vesper_property> = 56;
template <>
inline constexpr uint32_t kFirstSize<vesper_property_use> = 72;
template <>
inline constexpr uint32_t kFirstSize<vesper_parameter_desc> = 80;
template <>
inline constexpr uint32_t kFirstSize<vesper_law_desc> = 112;
template <>
inline constexpr uint32_t kFirstSize<vesper_field_desc> = 64;
template <>
inline constexpr uint32_t kFirstSize<vesper_law_library> = 48;
template <>
inline constexpr uint32_t kFirstSize<vesper_provider_callbacks> = 32;
template <>
inline constexpr uint32_t kFirstSize<vesper_engine_config> = 48;
template <>
inline constexpr uint32_t kFirstSize<vesper_law_info> = 88;
template <>
inline constexpr uint32_t kFirstSize<vesper_ledger_entry> = 80;

/// Maximum size [bytes] of any future struct; detects uninitialised sizes.
inline constexpr uint32_t kMaxStructSize = 4096;

/// Throws if no version of the struct can have this size.
template <class T>
void CheckStructSize(uint32_t size, const char* what) {
  static_assert(kFirstSize<T> > 0, "say above what the struct measured when it was new");
  static_assert(sizeof(T) >= kFirstSize<T>, "fields are only appended");
  if (size < kFirstSize<T> || size > kMaxStructSize || size % alignof(T) != 0) {
    throw Failure(VESPER_INVALID_ARGUMENT, "%s.struct_size is %u, expected sizeof = %zu", what,
                  size, sizeof(T));
  }
}

/// Returns the caller's struct, converted to the layout of this build. Throws INVALID_ARGUMENT for
/// an impossible size, and ABI_MISMATCH if a field of a newer contract that this build does not
/// support is not zero.
template <class T>
T ReadStruct(const T& source, const char* what) {
  const uint32_t size = source.struct_size;
  CheckStructSize<T>(size, what);
  T known{};
  std::memcpy(static_cast<void*>(&known), &source, std::min<size_t>(size, sizeof known));
  known.struct_size = sizeof known;
  const auto* bytes = reinterpret_cast<const std::byte*>(&source);
  const bool asks_for_more =
      size > sizeof known &&
      std::any_of(bytes + sizeof known, bytes + size, [](std::byte b) { return b != std::byte{}; });
  if (asks_for_more) {
    throw Failure(VESPER_ABI_MISMATCH,
                  "%s uses a field that contract %u.%u does not have; it needs a newer engine",
                  what, VESPER_ABI_MAJOR, VESPER_ABI_MINOR);
  }
  return known;
}

/// Converts an array of structs as ReadStruct does. The stride of the source is the `struct_size`
/// of its first element.
template <class T>
std::vector<T> ReadStructs(const T* first, uint32_t count, const char* what) {
  std::vector<T> known;
  if (count == 0) return known;
  if (first == nullptr) throw Failure(VESPER_INVALID_ARGUMENT, "%s is null", what);
  const uint32_t stride = first->struct_size;
  CheckStructSize<T>(stride, what);
  const auto* bytes = reinterpret_cast<const std::byte*>(first);
  for (uint32_t i = 0; i < count; ++i) {
    const T& element = *reinterpret_cast<const T*>(bytes + size_t{i} * stride);
    if (element.struct_size != stride) {
      throw Failure(VESPER_INVALID_ARGUMENT, "%s[%u].struct_size is %u, expected %u as in [0]",
                    what, i, element.struct_size, stride);
    }
    known.push_back(ReadStruct(element, what));
  }
  return known;
}

/// Fills the caller's struct up to its `struct_size`; fields unknown to this build are zero.
template <class T>
void WriteStruct(T& out, const T& value, const char* what) {
  const uint32_t size = out.struct_size;
  CheckStructSize<T>(size, what);
  std::memset(static_cast<void*>(&out), 0, size);
  std::memcpy(static_cast<void*>(&out), &value, std::min<size_t>(size, sizeof value));
  out.struct_size = size;
}

}  // namespace vesper
