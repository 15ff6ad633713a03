// SPDX-License-Identifier: Apache-2.0
// The property provider: which array of the client stands for which property.
#pragma once

#include <cstdint>
#include <vector>

#include "aligned_buffer.hpp"
#include "prototype.hpp"

namespace vesper {

/// The client's arrays as given to add or rebind; borrowed.
struct Arrays {
  void* data;
  uint64_t value_count;
  const uint32_t* indices;
  uint64_t row_count;

  bool operator==(const Arrays&) const = default;
};

/// One property of the prototype, bound or not.
struct Column {
  bool bound = false;
  bool stale = false;  // to be expanded and range-checked before anybody reads it
  Arrays arrays{};
  uint64_t version = 0;
  vesper_field field{};  // where the property is one
  AlignedBuffer dense;   // the rows, where the client shares values through indices

  /// Rows, dense; null if there are none.
  std::byte* data() const {
    return arrays.indices != nullptr ? dense.data() : static_cast<std::byte*>(arrays.data);
  }
};

/// Memory of the client's that stands for a property.
struct Extent {
  uintptr_t begin, end;
  uint32_t property;
  bool written;  // by laws, or by the engine
};

/// All columns of an engine, in prototype order. Not thread-safe.
class Columns {
 public:
  explicit Columns(const Prototype& prototype);

  void Add(uint32_t property, const Arrays& arrays);
  void Rebind(uint32_t property, const Arrays& arrays);
  /// Binds a field, or another one; it is copied.
  void SetField(uint32_t property, const vesper_field& field);
  void Remove(uint32_t property);
  /// Throws if these cannot stand for the property, whatever else is bound.
  void Check(uint32_t property, const Arrays& arrays) const;
  void CheckField(uint32_t property, const vesper_field& field) const;
  /// Adds or rebinds arrays that passed Check; row counts are agreed by Refresh.
  void Provide(uint32_t property, const Arrays& arrays);
  void Touch(uint32_t property);

  const Column& operator[](uint32_t property) const { return columns_[property]; }
  const PropertySpec& spec(uint32_t property) const { return prototype_.properties()[property]; }
  uint32_t size() const { return static_cast<uint32_t>(columns_.size()); }
  /// Rows of a kind as of the last Refresh; 0 if no property of the kind is bound.
  uint64_t row_count(uint32_t kind) const { return row_counts_[kind]; }
  /// Raised by every change.
  uint64_t generation() const { return generation_; }

  /// Agrees the row counts, holds arrays that laws may write apart from all others, expands shared
  /// values, and holds references to their range and values to their minimum, of what changed.
  /// Throws COUNT_MISMATCH, ACCESS_CONFLICT or INVALID_ARGUMENT that names property and row.
  void Refresh();
  /// Range-checks references again, changed or not.
  void CheckReferences();

 private:
  void AgreeRowCounts();
  void CheckApart();
  void Expand(uint32_t property);
  void CheckReference(uint32_t property) const;
  void CheckMinimum(uint32_t property) const;

  const Prototype& prototype_;
  std::vector<Column> columns_;
  std::vector<uint64_t> row_counts_;  // by kind
  uint64_t generation_ = 1;
  uint64_t refreshed_ = 0;
  std::vector<Extent> extents_;  // kept for its memory
};

}  // namespace vesper
