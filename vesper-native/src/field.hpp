// SPDX-License-Identifier: Apache-2.0
// Conversion of fields, which are functions of position.
#pragma once

#include "kernels.hpp"
#include "vesper/types.h"

namespace vesper {

/// A field with its values converted to another unit. It must keep its address while `field()` is
/// in use.
class ConvertedField {
 public:
  ConvertedField(const vesper_field& source, UnitRatio ratio, uint32_t components)
      : source_(source), ratio_(ratio), components_(components) {}
  ConvertedField(const ConvertedField&) = delete;
  ConvertedField& operator=(const ConvertedField&) = delete;

  vesper_field field() { return {sizeof(vesper_field), 0, this, Evaluate}; }

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
};

}  // namespace vesper
