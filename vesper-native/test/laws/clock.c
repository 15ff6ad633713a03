// SPDX-License-Identifier: Apache-2.0
/* Writes the time into each body: acceleration = (time, dt, index) of the last step. */
#define USE_COUNT 1
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  double* acceleration = law->bound[0].data;
  (void)error;
  for (uint64_t i = 0; i < law->bound[0].row_count; ++i) {
    acceleration[3 * i] = step->time;
    acceleration[3 * i + 1] = step->dt;
    acceleration[3 * i + 2] = (double)step->index;
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("acceleration", 3, VESPER_WRITE, VESPER_UNIT_METRE_PER_SECOND_SQUARED)};
static const vesper_law_desc kLaws[] = {
    LAW("clock", VESPER_PHASE_OBSERVE, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY("clock", kLaws, NULL, NULL)
