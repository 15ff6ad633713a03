// SPDX-License-Identifier: Apache-2.0
/* Semi-implicit Euler. A body with mass 0 is immovable. Compile definitions: NAME and STAGES. */
#define USE_COUNT 4
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)error;
  if (step->stage != step->stage_count) return VESPER_OK;
  const double* mass = law->bound[0].data;
  const double* force = law->bound[1].data;
  double* velocity = law->bound[2].data;
  double* position = law->bound[3].data;
  for (uint64_t row = 0; row < law->bound[0].row_count; ++row) {
    if (mass[row] == 0) continue;
    for (int c = 0; c < 3; ++c) {
      velocity[3 * row + c] += force[3 * row + c] / mass[row] * step->dt;
      position[3 * row + c] += velocity[3 * row + c] * step->dt;
    }
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    REAL_USE("externalForce", 3, VESPER_READ, VESPER_UNIT_NEWTON),
    REAL_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND),
    REAL_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
};
static const vesper_law_desc kLaws[] = {
    LAW(NAME, VESPER_PHASE_INTEGRATE, STAGES, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY(NAME, kLaws, NULL, NULL)
