// SPDX-License-Identifier: Apache-2.0
/* Two laws. `twist` applies the torque (0, 2, 0) to every body. `turn` integrates the angular
 * velocities of bodies whose three moments of inertia are equal and not 0. */
#define USE_COUNT 3
#include "test_law.h"

static vesper_status BindTorque(vesper_law* law, const vesper_property* properties,
                                vesper_error* error) {
  (void)error;
  law->bound[0] = properties[0];
  return VESPER_OK;
}

static vesper_status Twist(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  (void)error;
  double* torque = law->bound[0].data;
  for (uint64_t row = 0; row < law->bound[0].row_count; ++row) torque[3 * row + 1] += 2;
  return VESPER_OK;
}

static vesper_status Turn(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)error;
  if (step->stage != step->stage_count) return VESPER_OK;
  const double* inertia = law->bound[0].data;
  const double* torque = law->bound[1].data;
  double* angular_velocity = law->bound[2].data;
  for (uint64_t i = 0; i < 3 * law->bound[0].row_count; ++i) {
    if (inertia[i] != 0) angular_velocity[i] += torque[i] / inertia[i] * step->dt;
  }
  return VESPER_OK;
}

static const vesper_property_use kTwist[] = {
    REAL_USE("torque", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON_METRE)};
static const vesper_property_use kTurn[] = {
    REAL_USE("inertia", 3, VESPER_READ, VESPER_UNIT_KILOGRAM_METRE_SQUARED),
    REAL_USE("torque", 3, VESPER_READ, VESPER_UNIT_NEWTON_METRE),
    REAL_USE("angularVelocity", 3, VESPER_READ_WRITE, VESPER_UNIT_RADIAN_PER_SECOND),
};
static const vesper_law_desc kLaws[] = {
    LAW("twist", VESPER_PHASE_FORCE, 0, kTwist, 1, NULL, 0, Create, BindTorque, Twist),
    LAW("turn", VESPER_PHASE_INTEGRATE, 1, kTurn, USE_COUNT, NULL, 0, Create, Bind, Turn),
};
LIBRARY("spinning", kLaws, NULL, NULL)
