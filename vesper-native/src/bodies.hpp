// SPDX-License-Identifier: Apache-2.0
// The properties of the motion of bodies, converted to f64 in SI units.
#pragma once

#include <cstdint>

#include "balance.hpp"
#include "columns.hpp"
#include "prototype.hpp"

namespace vesper {

/// A column of reals, read as SI values.
struct SiColumn {
  const std::byte* data = nullptr;
  vesper_scalar_type type = VESPER_F64;
  double scale = 1;

  double Value(uint64_t index) const {
    const double value = type == VESPER_F32 ? reinterpret_cast<const float*>(data)[index]
                                            : reinterpret_cast<const double*>(data)[index];
    return value * scale;
  }
  Vector Row(uint64_t row) const {
    return {Value(3 * row), Value(3 * row + 1), Value(3 * row + 2)};
  }
};

/// The bodies: the rows of the kind that has the property `mass`. Properties are found by their
/// names in the standard prototypes.
class Bodies {
 public:
  /// Finds the properties. Throws NOT_FOUND if the prototype has no mass, position or velocity, and
  /// TYPE_MISMATCH or UNIT_MISMATCH if a property with a known name has another type or unit.
  Bodies(const Prototype& prototype, const Columns& columns);

  /// Reads the bound arrays, which must be current (no deferred writes). Throws NOT_FOUND if mass,
  /// position or velocity is not bound.
  void Bind();
  uint64_t count() const { return columns_[mass_].arrays.row_count; }

  /// Returns true if forces move the body. The ledger adds the impulses on an immovable body to the
  /// line of the ground.
  bool Moves(uint64_t row) const { return masses_.Value(row) != 0; }
  /// Returns true if torques rotate the body.
  bool Turns(uint64_t row) const;
  Vector Position(uint64_t row) const { return positions_.Row(row); }
  Vector Velocity(uint64_t row) const { return velocities_.Row(row); }
  /// Returns the angular velocity; the property must be bound.
  Vector AngularVelocity(uint64_t row) const { return angular_velocities_.Row(row); }

  /// Returns momentum, angular momentum and energy of all bodies, summed in row order.
  Balance Total() const;

  /// Returns a view of `data`, an array in the engine's memory that has the layout of the property.
  SiColumn View(uint32_t property, const void* data) const;

  /// Return the indices of properties in the prototype. All except that of velocity may be kNone.
  uint32_t velocity() const { return velocity_; }
  uint32_t angular_velocity() const { return angular_velocity_; }
  uint32_t force() const { return force_; }
  uint32_t torque() const { return torque_; }
  /// Returns true if the result of Total depends on the property.
  bool Count(uint32_t property) const;

 private:
  uint32_t Find(const char* name, uint32_t components, const vesper_unit& unit) const;
  uint32_t Require(const char* name, uint32_t components, const vesper_unit& unit) const;
  SiColumn Bound(uint32_t property) const;
  SiColumn RequireBound(uint32_t property) const;
  /// Returns the angular momentum about the centre of mass, in the world frame.
  Vector Spin(uint64_t row) const;
  /// Rotates a vector from the body frame to the world frame; direction -1 rotates it back.
  Vector ToWorld(uint64_t row, const Vector& v, double direction) const;

  const Prototype& prototype_;
  const Columns& columns_;
  uint32_t mass_, position_, velocity_;
  uint32_t orientation_, angular_velocity_, inertia_, force_, torque_;
  SiColumn masses_, positions_, velocities_;
  SiColumn orientations_, angular_velocities_, inertias_;  // data is null if the property is not
                                                           // bound
};

}  // namespace vesper
