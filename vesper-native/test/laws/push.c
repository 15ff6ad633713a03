// SPDX-License-Identifier: Apache-2.0
/* Adds the force (force, 0, 0) to every body, in two halves. Compile definitions: NAME and
 * FORCE. */
#define PARAMETER_COUNT 1
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  (void)error;
  double* force = law->bound[0].data;
  for (uint64_t row = 0; row < law->bound[0].row_count; ++row) {
    force[3 * row] += law->parameters[0] / 2;
    force[3 * row] += law->parameters[0] / 2;
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("force", VESPER_UNIT_NEWTON, FORCE, -HUGE_VAL, HUGE_VAL)};
static const vesper_law_desc kLaws[] = {LAW(NAME, VESPER_PHASE_FORCE, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY(NAME, kLaws, NULL, NULL)
