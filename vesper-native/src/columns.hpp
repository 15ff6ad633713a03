// SPDX-License-Identifier: Apache-2.0
// The property provider: the mapping from properties to arrays of the client.
#pragma once

#include <cstdint>
#include <vector>

#include "aligned_buffer.hpp"
#include "prototype.hpp"

namespace vesper {

/// The client's arrays, as passed to the functions that add or rebind a property. The memory
/// belongs to the client.
struct Arrays {
  void* data;
  uint64_t value_count;
  const uint32_t* indices;
  uint64_t row_count;

  bool operator==(const Arrays&) const = default;
};

/// One property of the prototype, bound or unbound.
struct Column {
  bool bound = false;
  bool stale = false;  // must be expanded and range-checked before use
  Arrays arrays{};
  uint64_t version = 0;
  vesper_field field{};  // the field of a FIELD property
  AlignedBuffer dense;   // expanded rows, if the client shares values through indices

  /// Returns the first of the dense rows; null if there are none.
  std::byte* data() const {
    return arrays.indices != nullptr ? dense.data() : static_cast<std::byte*>(arrays.data);
  }
};

/// Memory of the client that belongs to a property.
struct Extent {
  uintptr_t begin, end;
  uint32_t property;
  bool written;  // laws or the engine may write it
};

/// All columns of an engine, in prototype order. Not thread-safe.
class Columns {
 public:
  explicit Columns(const Prototype& prototype);

  void Add(uint32_t property, const Arrays& arrays);
  void Rebind(uint32_t property, const Arrays& arrays);
  /// Binds or replaces a field; copies `field`.
  void SetField(uint32_t property, const vesper_field& field);
  void Remove(uint32_t property);
  /// Throws if the arrays are invalid for the property, independently of other bound arrays.
  void Check(uint32_t property, const Arrays& arrays) const;
  void CheckField(uint32_t property, const vesper_field& field) const;
  /// Adds or rebinds arrays that passed Check. Their row counts are compared later, by Refresh.
  void Provide(uint32_t property, const Arrays& arrays);
  void Touch(uint32_t property);

  const Column& operator[](uint32_t property) const { return columns_[property]; }
  const PropertySpec& spec(uint32_t property) const { return prototype_.properties()[property]; }
  uint32_t size() const { return static_cast<uint32_t>(columns_.size()); }
  /// Returns the number of rows of a kind at the last Refresh; 0 if no property of the kind is
  /// bound.
  uint64_t row_count(uint32_t kind) const { return row_counts_[kind]; }
  /// Returns a number that increases with every change.
  uint64_t generation() const { return generation_; }

  /// Checks and updates changed columns:
  /// - compares the row counts of the properties of a kind;
  /// - checks that arrays that laws may write overlap no other array;
  /// - expands shared values;
  /// - checks references against their range, and values against their minimum.
  /// Throws COUNT_MISMATCH, ACCESS_CONFLICT or INVALID_ARGUMENT with property and row.
  void Refresh();
  /// Range-checks all references, also unchanged ones.
  void CheckReferences();

 private:
  void AgreeRowCounts();
  void CheckApart();
  void Expand(uint32_t property);
  void CheckReference(uint32_t property) const;
  void CheckMinimum(uint32_t property) const;

  const Prototype& prototype_;
  std::vector<Column> columns_;
  std::vector<uint64_t> row_counts_;  // row counts by kind
  uint64_t generation_ = 1;
  uint64_t refreshed_ = 0;
  std::vector<Extent> extents_;  // reused to avoid allocations
};

}  // namespace vesper
