// SPDX-License-Identifier: Apache-2.0
// A column for a property of any scalar type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "vesper/law.hpp"
#include "vesper/vesper.hpp"

namespace vesper {

/// A column (rows x components) of any scalar type, with values read and written as doubles.
class AnyColumn {
 public:
  AnyColumn(const vesper_property_descriptor& descriptor, uint64_t rows);

  const vesper_property_descriptor& descriptor() const { return *descriptor_; }
  uint64_t rows() const { return rows_; }
  uint64_t size() const { return rows_ * descriptor_->components; }
  bool is_real() const;
  /// Returns true if the three components of a row rotate with the world.
  bool is_vector() const;
  void* data() { return bytes_.data(); }
  const std::vector<std::byte>& bytes() const { return bytes_; }

  double Get(uint64_t value) const;
  void Set(uint64_t value, double to);
  /// Returns a row of a column with three components.
  Vec3<double> GetVector(uint64_t row) const;
  void SetVector(uint64_t row, const Vec3<double>& to);
  /// Returns the largest absolute value.
  double Largest() const;
  void AddTo(PhysicalPropertyProvider provider);

 private:
  template <class Action>
  static auto Visit(vesper_scalar_type type, Action&& action);

  const vesper_property_descriptor* descriptor_;
  uint64_t rows_;
  std::vector<std::byte> bytes_;
};

}  // namespace vesper
