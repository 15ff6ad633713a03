// SPDX-License-Identifier: Apache-2.0
#include "vesper/kit/field.hpp"

#include <cmath>

namespace vesper {

const vesper_field& AnalyticField::function() {
  function_ = {sizeof function_, 0, this, Evaluate};
  return function_;
}

void AnalyticField::Rotate(const Quaternion& by) {
  origin_ = Rotated(origin_, by);
  turn_ = by * turn_;
}

void AnalyticField::Evaluate(void* user, uint64_t count, const double* at, double* out) {
  const auto& self = *static_cast<const AnalyticField*>(user);
  const uint32_t components = self.descriptor_->components;
  for (uint64_t i = 0; i < count; ++i) {
    self.EvaluateOne({at[3 * i], at[3 * i + 1], at[3 * i + 2]}, out + i * components);
  }
}

void AnalyticField::EvaluateOne(const Vec3<double>& at, double* out) const {
  const Vec3<double> x = Rotated(at - origin_, turn_.Conjugate());
  if (descriptor_->components == 3) {
    const Vec3<double> value = Rotated({std::sin(x.y), std::sin(x.z), std::sin(x.x)}, turn_);
    out[0] = value.x;
    out[1] = value.y;
    out[2] = value.z;
    return;
  }
  for (uint32_t c = 0; c < descriptor_->components; ++c) {
    out[c] = 1.25 + 0.75 * std::sin(x.x + x.y + x.z + c);
  }
}

}  // namespace vesper
