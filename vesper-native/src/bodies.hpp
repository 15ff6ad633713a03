// SPDX-License-Identifier: Apache-2.0
// The columns that say how bodies move, as mechanics reads them: f64, in SI units.
#pragma once

#include <cstdint>

#include "balance.hpp"
#include "columns.hpp"
#include "prototype.hpp"

namespace vesper {

/// A column of reals, as SI values.
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

/// Bodies are the rows of the kind that `mass` belongs to. Properties are known by the names they
/// have in the standard prototypes.
class Bodies {
 public:
  /// Throws NOT_FOUND if the prototype has no mass, position or velocity, and TYPE_MISMATCH or
  /// UNIT_MISMATCH if a property of a name that is known here is something else.
  Bodies(const Prototype& prototype, const Columns& columns);

  /// Takes over the arrays as they are bound, which are fresh. Throws NOT_FOUND if mass, position
  /// or velocity is not.
  void Bind();
  uint64_t count() const { return columns_[mass_].arrays.row_count; }

  /// Whether forces move the body; else it hands them on to the ground.
  bool Moves(uint64_t row) const { return masses_.Value(row) != 0; }
  /// Whether torques turn it.
  bool Turns(uint64_t row) const;
  Vector Position(uint64_t row) const { return positions_.Row(row); }
  Vector Velocity(uint64_t row) const { return velocities_.Row(row); }
  /// Only where that property is bound.
  Vector AngularVelocity(uint64_t row) const { return angular_velocities_.Row(row); }

  /// Of all bodies, summed in the order of rows.
  Balance Total() const;

  /// `data` stands for rows of the property, in the engine's memory.
  SiColumn View(uint32_t property, const void* data) const;

  /// Properties of the prototype; those after velocity may be kNone.
  uint32_t velocity() const { return velocity_; }
  uint32_t angular_velocity() const { return angular_velocity_; }
  uint32_t force() const { return force_; }
  uint32_t torque() const { return torque_; }
  /// Whether Total depends on the property.
  bool Count(uint32_t property) const;

 private:
  uint32_t Find(const char* name, uint32_t components, const vesper_unit& unit) const;
  uint32_t Require(const char* name, uint32_t components, const vesper_unit& unit) const;
  SiColumn Bound(uint32_t property) const;
  SiColumn RequireBound(uint32_t property) const;
  /// Angular momentum about the centre of mass, in the world frame.
  Vector Spin(uint64_t row) const;
  /// A vector of the body frame in the world frame; with direction -1 the other way.
  Vector ToWorld(uint64_t row, const Vector& v, double direction) const;

  const Prototype& prototype_;
  const Columns& columns_;
  uint32_t mass_, position_, velocity_;
  uint32_t orientation_, angular_velocity_, inertia_, force_, torque_;
  SiColumn masses_, positions_, velocities_;
  SiColumn orientations_, angular_velocities_, inertias_;  // data null: not bound
};

}  // namespace vesper
