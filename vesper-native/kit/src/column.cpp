// SPDX-License-Identifier: Apache-2.0
#include "vesper/kit/column.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>

namespace vesper {

template <class Action>
auto AnyColumn::Visit(vesper_scalar_type type, Action&& action) {
  switch (type) {
    case VESPER_F32:
      return action(float{});
    case VESPER_F64:
      return action(double{});
    case VESPER_I32:
      return action(int32_t{});
    case VESPER_U32:
      return action(uint32_t{});
  }
  throw std::logic_error("no such scalar type");
}

AnyColumn::AnyColumn(const vesper_property_descriptor& descriptor, uint64_t rows)
    : descriptor_(&descriptor), rows_(rows) {
  bytes_.resize(Visit(descriptor.scalar_type, [&](auto scalar) { return size() * sizeof scalar; }));
}

bool AnyColumn::is_real() const {
  return descriptor_->scalar_type == VESPER_F32 || descriptor_->scalar_type == VESPER_F64;
}

bool AnyColumn::is_vector() const {
  const std::string name = descriptor_->name;
  const bool own_axes = name == "inertia" || name == "size" || name == "scenerySize";
  return is_real() && descriptor_->components == 3 && !own_axes;
}

double AnyColumn::Get(uint64_t value) const {
  return Visit(descriptor_->scalar_type, [&](auto scalar) {
    std::memcpy(&scalar, bytes_.data() + value * sizeof scalar, sizeof scalar);
    return static_cast<double>(scalar);
  });
}

void AnyColumn::Set(uint64_t value, double to) {
  Visit(descriptor_->scalar_type, [&](auto scalar) {
    scalar = static_cast<decltype(scalar)>(to);
    std::memcpy(bytes_.data() + value * sizeof scalar, &scalar, sizeof scalar);
  });
}

Vec3<double> AnyColumn::GetVector(uint64_t row) const {
  return {Get(3 * row), Get(3 * row + 1), Get(3 * row + 2)};
}

void AnyColumn::SetVector(uint64_t row, const Vec3<double>& to) {
  Set(3 * row, to.x);
  Set(3 * row + 1, to.y);
  Set(3 * row + 2, to.z);
}

double AnyColumn::Largest() const {
  double largest = 0;
  for (uint64_t i = 0; i < size(); ++i) largest = std::max(largest, std::abs(Get(i)));
  return largest;
}

void AnyColumn::AddTo(PhysicalPropertyProvider provider) {
  Visit(descriptor_->scalar_type, [&](auto scalar) {
    provider.AddPhysicalProperty(
        descriptor_->name, std::span(reinterpret_cast<decltype(scalar)*>(bytes_.data()), size()));
  });
}

}  // namespace vesper
