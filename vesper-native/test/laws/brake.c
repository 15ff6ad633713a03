// SPDX-License-Identifier: Apache-2.0
/* Reduces every velocity by a tenth, after the integrators. */
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  (void)error;
  double* velocity = law->bound[0].data;
  for (uint64_t i = 0; i < 3 * law->bound[0].row_count; ++i) velocity[i] *= 0.9;
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};
static const vesper_law_desc kLaws[] = {
    LAW("brake", VESPER_PHASE_CONSTRAIN, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY("brake", kLaws, NULL, NULL)
