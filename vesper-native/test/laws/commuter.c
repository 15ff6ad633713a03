// SPDX-License-Identifier: Apache-2.0
/* Uses km, km/h and kN. Accelerates every other body, pushes all, and records their positions. */
#define USE_COUNT 4
#define PARAMETER_COUNT 1
#include "test_law.h"

#define KILOMETRE VESPER_UNIT_INIT(1, 0, 0, 0, 0, 0, 0, 1000.0, "km")
#define KILOMETRE_PER_HOUR VESPER_UNIT_INIT(1, 0, -1, 0, 0, 0, 0, 1000.0 / 3600, "km/h")
#define KILONEWTON VESPER_UNIT_INIT(1, 1, -2, 0, 0, 0, 0, 1000.0, "kN")
#define KILOMETRE_PER_SECOND_SQUARED VESPER_UNIT_INIT(1, 0, -2, 0, 0, 0, 0, 1000.0, "km/s^2")

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  const double* position = law->bound[0].data;
  double* velocity = law->bound[1].data;
  double* force = law->bound[2].data;
  double* acceleration = law->bound[3].data;
  (void)step;
  (void)error;
  for (uint64_t row = 0; row < law->bound[0].row_count; ++row) {
    if (row % 2 == 0) velocity[3 * row] += 36;
    force[3 * row] += law->parameters[0];
    for (int c = 0; c < 3; ++c) acceleration[3 * row + c] = position[3 * row + c];
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("position", 3, VESPER_READ, KILOMETRE),
    REAL_USE("velocity", 3, VESPER_READ_WRITE, KILOMETRE_PER_HOUR),
    REAL_USE("externalForce", 3, VESPER_ACCUMULATE, KILONEWTON),
    REAL_USE("acceleration", 3, VESPER_WRITE, KILOMETRE_PER_SECOND_SQUARED),
};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("force", KILONEWTON, 2.0, -1e308, 1e308)};
static const vesper_law_desc kLaws[] = {LAW("commuter", VESPER_PHASE_FORCE, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY("commuter", kLaws, NULL, NULL)
