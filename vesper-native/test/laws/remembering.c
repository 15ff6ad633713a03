// SPDX-License-Identifier: Apache-2.0
/* Adds each body's mass to a SCRATCH sum, counts its advances, and writes both to the acceleration.
 * Fails after "failAt" steps. */
#define USE_COUNT 4
#define PARAMETER_COUNT 1
#include "test_law.h"

#ifndef COMPONENTS
#define COMPONENTS 1
#endif

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  const double* mass = law->bound[0].data;
  double* shown = law->bound[1].data;
  double* sum = law->bound[2].data;
  uint32_t* count = law->bound[3].data;
  for (uint64_t row = 0; row < law->bound[2].row_count; ++row) {
    sum[row] += mass[row];
    count[2 * row + 1] += 1;
    shown[3 * row] = sum[row];
    shown[3 * row + 1] = count[2 * row];
    shown[3 * row + 2] = count[2 * row + 1];
  }
  if ((double)step->index == law->parameters[0]) {
    return Fail(error, VESPER_LAW_FAILED, "as told");
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    REAL_USE("acceleration", 3, VESPER_WRITE, VESPER_UNIT_METRE_PER_SECOND_SQUARED),
    USE("sum", KIND, VESPER_F64, COMPONENTS, VESPER_SCRATCH, VESPER_UNIT_ONE, FLAGS),
    USE("count", KIND, VESPER_U32, 2, VESPER_SCRATCH, VESPER_UNIT_ONE, 0),
};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("failAt", VESPER_UNIT_ONE, -1, -1, HUGE_VAL)};
static const vesper_law_desc kLaws[] = {LAW(NAME, VESPER_PHASE_OBSERVE, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY(NAME, kLaws, NULL, NULL)
