// SPDX-License-Identifier: Apache-2.0
// A test field: a smooth function that moves and rotates with its world.
#pragma once

#include <cstdint>

#include "vesper/engine.h"
#include "vesper/kit/quaternion.hpp"

namespace vesper {

class AnalyticField {
 public:
  /// Creates a field. Its values are vectors in a cube of side 2, or numbers from 0.5 to 2. The
  /// columns of a World have values in the same ranges.
  explicit AnalyticField(const vesper_property_descriptor& descriptor) : descriptor_(&descriptor) {}

  const vesper_property_descriptor& descriptor() const { return *descriptor_; }
  /// Returns the C form, borrowed from this object, which must keep its address.
  const vesper_field& function();

  void Translate(const Vec3<double>& by) { origin_ += by; }
  /// Rotates the field about the origin of the world.
  void Rotate(const Quaternion& by);

 private:
  static void Evaluate(void* user, uint64_t count, const double* at, double* out);
  void EvaluateOne(const Vec3<double>& at, double* out) const;

  const vesper_property_descriptor* descriptor_;
  Vec3<double> origin_{};
  Quaternion turn_;
  vesper_field function_{};
};

}  // namespace vesper
