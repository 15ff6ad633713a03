// SPDX-License-Identifier: Apache-2.0
#include "bodies.hpp"

#include "failure.hpp"
#include "unit.hpp"
#include "vesper/units.h"

namespace vesper {

Bodies::Bodies(const Prototype& prototype, const Columns& columns)
    : prototype_(prototype),
      columns_(columns),
      mass_(Require("mass", 1, VESPER_UNIT_KILOGRAM)),
      position_(Require("position", 3, VESPER_UNIT_METRE)),
      velocity_(Require("velocity", 3, VESPER_UNIT_METRE_PER_SECOND)),
      orientation_(Find("orientation", 4, VESPER_UNIT_ONE)),
      angular_velocity_(Find("angularVelocity", 3, VESPER_UNIT_RADIAN_PER_SECOND)),
      inertia_(Find("inertia", 3, VESPER_UNIT_KILOGRAM_METRE_SQUARED)),
      force_(Find("externalForce", 3, VESPER_UNIT_NEWTON)),
      torque_(Find("torque", 3, VESPER_UNIT_NEWTON_METRE)) {}

uint32_t Bodies::Require(const char* name, uint32_t components, const vesper_unit& unit) const {
  const uint32_t property = Find(name, components, unit);
  if (property != kNone) return property;
  throw Failure(VESPER_NOT_FOUND,
                "the ledger needs property %s: real x %u [%s], which prototype %s does not have",
                name, components, unit.symbol, prototype_.name().c_str())
      .Property(name);
}

uint32_t Bodies::Find(const char* name, uint32_t components, const vesper_unit& unit) const {
  const uint32_t property = prototype_.Find(name);
  if (property == kNone) return kNone;
  const PropertySpec& spec = prototype_.properties()[property];
  if (!IsReal(spec.type) || spec.components != components) {
    throw Failure(VESPER_TYPE_MISMATCH, "property %s: is %s, the ledger expects real x %u", name,
                  DescribeType(spec.type, spec.components).c_str(), components)
        .Property(name);
  }
  if (!SameDimension(spec.unit, unit)) {
    throw Failure(VESPER_UNIT_MISMATCH, "property %s: is in %s, the ledger expects %s", name,
                  Describe(spec.unit).c_str(), Describe(unit).c_str())
        .Property(name);
  }
  const uint32_t kind = prototype_.properties()[prototype_.Find("mass")].kind;
  if (spec.kind != kind) {
    throw Failure(VESPER_TYPE_MISMATCH, "property %s: is of kind %s, but mass is of kind %s", name,
                  prototype_.kinds()[spec.kind].c_str(), prototype_.kinds()[kind].c_str())
        .Property(name);
  }
  return property;
}

void Bodies::Bind() {
  masses_ = RequireBound(mass_);
  positions_ = RequireBound(position_);
  velocities_ = RequireBound(velocity_);
  orientations_ = Bound(orientation_);
  angular_velocities_ = Bound(angular_velocity_);
  inertias_ = Bound(inertia_);
}

SiColumn Bodies::RequireBound(uint32_t property) const {
  if (columns_[property].bound) return Bound(property);
  const std::string& name = columns_.spec(property).name;
  throw Failure(VESPER_NOT_FOUND, "the ledger needs property %s, which is not bound; add it first",
                name.c_str())
      .Property(name);
}

SiColumn Bodies::Bound(uint32_t property) const {
  if (property == kNone || !columns_[property].bound) return {};
  return View(property, columns_[property].data());
}

SiColumn Bodies::View(uint32_t property, const void* data) const {
  const PropertySpec& spec = columns_.spec(property);
  return {static_cast<const std::byte*>(data), spec.type, spec.unit.scale};
}

bool Bodies::Count(uint32_t property) const {
  return property != kNone &&
         (property == mass_ || property == position_ || property == velocity_ ||
          property == orientation_ || property == angular_velocity_ || property == inertia_);
}

bool Bodies::Turns(uint64_t row) const {
  if (inertias_.data == nullptr) return false;
  const Vector inertia = inertias_.Row(row);
  return inertia.x != 0 || inertia.y != 0 || inertia.z != 0;
}

Balance Bodies::Total() const {
  Balance total;
  const bool turning = inertias_.data != nullptr && angular_velocities_.data != nullptr;
  for (uint64_t row = 0; row < count(); ++row) {
    if (Moves(row)) {
      const Vector momentum = Velocity(row) * masses_.Value(row);
      total.momentum += momentum;
      total.angular_momentum += Cross(Position(row), momentum);
      total.energy += Dot(momentum, Velocity(row)) / 2;
    }
    if (turning && Turns(row)) {
      const Vector spin = Spin(row);
      total.angular_momentum += spin;
      total.energy += Dot(spin, AngularVelocity(row)) / 2;
    }
  }
  return total;
}

/// Returns the angular momentum of a body; the property inertia is given in the body's own axes.
Vector Bodies::Spin(uint64_t row) const {
  const Vector rate = ToWorld(row, AngularVelocity(row), -1);
  const Vector inertia = inertias_.Row(row);
  return ToWorld(row, {inertia.x * rate.x, inertia.y * rate.y, inertia.z * rate.z}, 1);
}

Vector Bodies::ToWorld(uint64_t row, const Vector& v, double direction) const {
  if (orientations_.data == nullptr) return v;
  const auto q = [&](uint64_t component) { return orientations_.Value(4 * row + component); };
  const Vector axis = Vector{q(0), q(1), q(2)} * direction;
  const Vector twice = Cross(axis, v) * 2;
  return v + twice * q(3) + Cross(axis, twice);
}

}  // namespace vesper
