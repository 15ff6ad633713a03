// SPDX-License-Identifier: Apache-2.0
// Conversion of fields, which are functions of position.
#pragma once

#include <string>

#include "kernels.hpp"
#include "vesper/law.h"

namespace vesper {

class ConvertedField;

/// The library that provides a field.
struct FieldProvider {
  vesper_library_id library = VESPER_NO_LIBRARY;
  std::string name = {};  // of the library
  uint32_t laws = 0;      // number of its laws
  const vesper_field_desc* desc = nullptr;
  vesper_suite* suite = nullptr;
  ConvertedField* slopes = nullptr;  // the values with their slopes; null: the slopes are unknown
};

/// Returns the number of values at each place that a use of a field reads.
inline uint32_t ValuesPerPlace(const vesper_property_use& use) {
  return use.components * ((use.flags & VESPER_USE_SLOPE) != 0 ? 4 : 1);
}

/// A field with its values converted to another unit. It must keep its address while `field()` is
/// in use.
class ConvertedField {
 public:
  /// `provider` is null if a client provides the field; it must outlive this object.
  ConvertedField(const vesper_field& source, UnitRatio ratio, uint32_t components,
                 const FieldProvider* provider = nullptr)
      : source_(source), ratio_(ratio), components_(components), provider_(provider) {}
  ConvertedField(const ConvertedField&) = delete;
  ConvertedField& operator=(const ConvertedField&) = delete;

  vesper_field field() { return {sizeof(vesper_field), 0, this, Evaluate}; }

  /// Returns the library that provides a field; null if a client provides it.
  static const FieldProvider* ProviderOf(const vesper_field& field) {
    if (field.evaluate != Evaluate) return nullptr;
    return static_cast<const ConvertedField*>(field.user)->provider_;
  }

 private:
  static void Evaluate(void* user, uint64_t count, const double* at, double* out) {
    const auto& self = *static_cast<const ConvertedField*>(user);
    self.source_.evaluate(self.source_.user, count, at, out);
    if (self.ratio_.IsOne()) return;
    Convert(VESPER_F64, out, out, self.ratio_, count * self.components_);
  }

  vesper_field source_;
  UnitRatio ratio_;
  uint32_t components_;
  const FieldProvider* provider_;
};

}  // namespace vesper
