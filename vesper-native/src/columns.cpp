// SPDX-License-Identifier: Apache-2.0
#include "columns.hpp"

#include <algorithm>
#include <cinttypes>

#include "failure.hpp"
#include "kernels.hpp"
#include "unit.hpp"
#include "versioned_struct.hpp"

namespace vesper {
namespace {

void CheckArrays(const PropertySpec& spec, const Arrays& arrays) {
  const auto fail = [&spec](vesper_status status, const char* what, uint64_t found) {
    return Failure(status, "property %s: %s (found %" PRIu64 ")", spec.name.c_str(), what, found)
        .Property(spec.name);
  };
  if (IsField(spec.type)) {
    throw Failure(VESPER_TYPE_MISMATCH,
                  "property %s is a field and has no arrays; use vesper_provider_set_field",
                  spec.name.c_str())
        .Property(spec.name);
  }
  if (arrays.value_count > INT64_MAX / spec.row_size) {
    throw fail(VESPER_INVALID_ARGUMENT, "value_count does not fit memory", arrays.value_count);
  }
  if (arrays.row_count > INT64_MAX / spec.row_size) {
    throw fail(VESPER_INVALID_ARGUMENT, "object_count does not fit memory", arrays.row_count);
  }
  if (arrays.data == nullptr && arrays.value_count > 0) {
    throw fail(VESPER_INVALID_ARGUMENT, "data is null but value_count is not 0",
               arrays.value_count);
  }
  const uint64_t misaligned = reinterpret_cast<uintptr_t>(arrays.data) % ScalarSize(spec.type);
  if (misaligned != 0) {
    throw fail(VESPER_INVALID_ARGUMENT, "data is not aligned to its scalar type", misaligned);
  }
  if (arrays.indices == nullptr && arrays.value_count != arrays.row_count) {
    throw Failure(VESPER_COUNT_MISMATCH,
                  "property %s: value_count %" PRIu64 ", expected object_count %" PRIu64
                  " (there are no indices)",
                  spec.name.c_str(), arrays.value_count, arrays.row_count)
        .Property(spec.name);
  }
  if (arrays.indices != nullptr && spec.IsAccumulator()) {
    throw Failure(VESPER_ACCESS_CONFLICT,
                  "property %s: the engine writes its sums, so rows cannot share values",
                  spec.name.c_str())
        .Property(spec.name);
  }
  if (reinterpret_cast<uintptr_t>(arrays.indices) % alignof(uint32_t) != 0) {
    throw fail(VESPER_INVALID_ARGUMENT, "indices are not aligned to 4 bytes",
               reinterpret_cast<uintptr_t>(arrays.indices) % alignof(uint32_t));
  }
}

}  // namespace

Columns::Columns(const Prototype& prototype)
    : prototype_(prototype),
      columns_(prototype.properties().size()),
      row_counts_(prototype.kinds().size()) {}

void Columns::Add(uint32_t property, const Arrays& arrays) {
  const PropertySpec& added = spec(property);
  if (columns_[property].bound) {
    throw Failure(VESPER_ALREADY_EXISTS, "property %s is bound already; rebind it or remove it",
                  added.name.c_str())
        .Property(added.name);
  }
  CheckArrays(added, arrays);
  for (uint32_t i = 0; i < size(); ++i) {
    if (!columns_[i].bound || spec(i).kind != added.kind || IsField(spec(i).type)) continue;
    if (columns_[i].arrays.row_count == arrays.row_count) continue;
    throw Failure(VESPER_COUNT_MISMATCH,
                  "property %s: object_count %" PRIu64 ", but %s of the same kind %s has %" PRIu64,
                  added.name.c_str(), arrays.row_count, spec(i).name.c_str(),
                  prototype_.kinds()[added.kind].c_str(), columns_[i].arrays.row_count)
        .Property(added.name);
  }
  Provide(property, arrays);
}

void Columns::Rebind(uint32_t property, const Arrays& arrays) {
  if (!columns_[property].bound) {
    throw Failure(VESPER_NOT_FOUND, "property %s is not bound; add it first",
                  spec(property).name.c_str())
        .Property(spec(property).name);
  }
  CheckArrays(spec(property), arrays);
  Provide(property, arrays);
}

void Columns::Check(uint32_t property, const Arrays& arrays) const {
  CheckArrays(spec(property), arrays);
}

void Columns::Provide(uint32_t property, const Arrays& arrays) {
  Column& column = columns_[property];
  column.bound = true;
  column.arrays = arrays;
  Touch(property);
}

void Columns::CheckField(uint32_t property, const vesper_field& field) const {
  const std::string& name = spec(property).name;
  if (!IsField(spec(property).type)) {
    throw Failure(VESPER_TYPE_MISMATCH, "property %s is no field; it has %s per row", name.c_str(),
                  DescribeType(spec(property).type, spec(property).components).c_str())
        .Property(name);
  }
  CheckStructSize<vesper_field>(field.struct_size, "field");
  if (field.evaluate == nullptr) {
    throw Failure(VESPER_INVALID_ARGUMENT, "property %s: field.evaluate is null", name.c_str())
        .Property(name);
  }
}

void Columns::SetField(uint32_t property, const vesper_field& field) {
  CheckField(property, field);
  Column& column = columns_[property];
  column.field = field;
  column.field.struct_size = sizeof column.field;
  column.bound = true;
  column.arrays = {&column.field, 0, nullptr, 0};
  Touch(property);
}

void Columns::Remove(uint32_t property) {
  Column& column = columns_[property];
  if (!column.bound) {
    throw Failure(VESPER_NOT_FOUND, "property %s is not bound", spec(property).name.c_str())
        .Property(spec(property).name);
  }
  column.bound = false;
  column.arrays = {};
  Touch(property);
}

void Columns::Touch(uint32_t property) {
  columns_[property].stale = true;
  ++columns_[property].version;
  ++generation_;
}

void Columns::Refresh() {
  if (refreshed_ == generation_) return;
  AgreeRowCounts();
  CheckApart();
  for (uint32_t i = 0; i < size(); ++i) {
    if (!columns_[i].bound || !columns_[i].stale) continue;
    if (columns_[i].arrays.indices != nullptr) Expand(i);
    if (spec(i).minimum && spec(i).law_access == VESPER_READ) CheckMinimum(i);
  }
  // Checks references again, because they may also become invalid when the number of rows of their
  // target kind decreases.
  CheckReferences();
  for (Column& column : columns_) column.stale = false;
  refreshed_ = generation_;
}

void Columns::AgreeRowCounts() {
  for (uint32_t kind = 0; kind < row_counts_.size(); ++kind) {
    uint32_t first = kNone;
    for (uint32_t i = 0; i < size(); ++i) {
      if (!columns_[i].bound || spec(i).kind != kind || IsField(spec(i).type)) continue;
      if (first == kNone) first = i;
      const uint64_t expected = columns_[first].arrays.row_count;
      const uint64_t found = columns_[i].arrays.row_count;
      if (found == expected) continue;
      throw Failure(VESPER_COUNT_MISMATCH,
                    "property %s has %" PRIu64 " rows, but %s of the same kind %s has %" PRIu64,
                    spec(i).name.c_str(), found, spec(first).name.c_str(),
                    prototype_.kinds()[kind].c_str(), expected)
          .Property(spec(i).name);
    }
    row_counts_[kind] = first == kNone ? 0 : columns_[first].arrays.row_count;
  }
}

/// Refuses overlapping arrays if one of them is written, because a write to one property must not
/// change another property.
void Columns::CheckApart() {
  extents_.clear();
  const auto add = [this](const void* data, uint64_t size, uint32_t property, bool written) {
    const auto begin = reinterpret_cast<uintptr_t>(data);
    if (size > 0) extents_.push_back({begin, begin + size, property, written});
  };
  for (uint32_t i = 0; i < size(); ++i) {
    const Arrays& arrays = columns_[i].arrays;
    if (!columns_[i].bound || IsField(spec(i).type)) continue;
    const bool written = (spec(i).law_access & (VESPER_WRITE | VESPER_ACCUMULATE)) != 0;
    add(arrays.data, arrays.value_count * spec(i).row_size, i, written);
    if (arrays.indices != nullptr) add(arrays.indices, arrays.row_count * 4, i, false);
  }
  std::sort(extents_.begin(), extents_.end(), [](const Extent& a, const Extent& b) {
    return a.begin != b.begin ? a.begin < b.begin : a.property < b.property;
  });
  // The variable `any` is the extent with the highest end among the extents visited so far. The
  // variable `written` is the extent with the highest end among those that are written.
  Extent any{}, written{};
  for (const Extent& extent : extents_) {
    const Extent& before = extent.written ? any : written;
    if (extent.begin < before.end) {
      const std::string& name = spec(extent.property).name;
      throw Failure(VESPER_ACCESS_CONFLICT,
                    "properties %s and %s share memory that laws may write; give each its own",
                    spec(before.property).name.c_str(), name.c_str())
          .Property(name);
    }
    if (extent.end > any.end) any = extent;
    if (extent.written && extent.end > written.end) written = extent;
  }
}

void Columns::Expand(uint32_t property) {
  const PropertySpec& expanded = spec(property);
  Column& column = columns_[property];
  const Arrays& arrays = column.arrays;
  const uint64_t bad = FindOutOfRange(arrays.indices, arrays.row_count, arrays.value_count);
  if (bad != kNotFound) {
    throw Failure(VESPER_INVALID_ARGUMENT,
                  "property %s: indices[%" PRIu64 "] is %u, but there are %" PRIu64 " values",
                  expanded.name.c_str(), bad, arrays.indices[bad], arrays.value_count)
        .Property(expanded.name)
        .Row(bad);
  }
  column.dense.Resize(arrays.row_count * expanded.row_size);
  Gather(column.dense.data(), arrays.data, arrays.indices, arrays.row_count, expanded.row_size);
}

void Columns::CheckMinimum(uint32_t property) const {
  const PropertySpec& bounded = spec(property);
  const std::byte* values = columns_[property].data();
  const uint64_t count = columns_[property].arrays.row_count * bounded.components;
  const uint64_t bad = FindBelow(bounded.type, values, count, *bounded.minimum);
  if (bad == kNotFound) return;
  throw Failure(VESPER_INVALID_ARGUMENT,
                "property %s, row %" PRIu64 ": is %g, expected %g or more [%s]",
                bounded.name.c_str(), bad / bounded.components, ValueAt(bounded.type, values, bad),
                *bounded.minimum, bounded.unit.symbol)
      .Property(bounded.name)
      .Row(bad / bounded.components);
}

void Columns::CheckReferences() {
  for (uint32_t i = 0; i < size(); ++i) {
    if (columns_[i].bound && spec(i).refers_to != kNone) CheckReference(i);
  }
}

void Columns::CheckReference(uint32_t property) const {
  const PropertySpec& reference = spec(property);
  const auto* rows = reinterpret_cast<const uint32_t*>(columns_[property].data());
  const uint64_t count = columns_[property].arrays.row_count * reference.components;
  const uint64_t limit = row_counts_[reference.refers_to];
  const uint64_t bad = FindOutOfRange(rows, count, limit);
  if (bad == kNotFound) return;
  throw Failure(VESPER_INVALID_ARGUMENT,
                "property %s: row %" PRIu64 " refers to row %u of kind %s, which has %" PRIu64
                " rows",
                reference.name.c_str(), bad / reference.components, rows[bad],
                prototype_.kinds()[reference.refers_to].c_str(), limit)
      .Property(reference.name)
      .Row(bad / reference.components);
}

}  // namespace vesper
