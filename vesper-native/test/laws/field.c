// SPDX-License-Identifier: Apache-2.0
/* A position-dependent force with rounding, computed through parallel_for. Compile definitions:
 * NAME and GRAIN. */
#define USE_COUNT 2
#include "test_law.h"

static void Range(void* user, uint64_t begin, uint64_t end) {
  vesper_law* law = user;
  const double* position = law->bound[0].data;
  double* force = law->bound[1].data;
  double chunk = 0; /* depends on the boundaries of the chunks */
  for (uint64_t i = 3 * begin; i < 3 * end; ++i) {
    chunk += 0.1 * position[i];
    force[i] += chunk * 1e-3 - position[i] / 3;
  }
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  (void)error;
  law->host->parallel_for(law->host->context, law->bound[0].row_count, GRAIN, Range, law);
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("position", 3, VESPER_READ, VESPER_UNIT_METRE),
    REAL_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON),
};
static const vesper_law_desc kLaws[] = {
    LAW(NAME, VESPER_PHASE_FORCE, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY(NAME, kLaws, NULL, NULL)
