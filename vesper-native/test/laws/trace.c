// SPDX-License-Identifier: Apache-2.0
/* Appends a digit to orientation.x at each call, to record the order. An integrator appends
 * DIGIT plus the stage, from FIRST_STAGE on if that is defined. Compile definitions: NAME,
 * PHASE, STAGES, DIGIT and FIRST_STAGE. */
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)error;
  double* orientation = law->bound[0].data;
  const uint32_t digit = DIGIT + (STAGES > 0 ? step->stage : 0);
  for (uint64_t row = 0; row < law->bound[0].row_count; ++row) {
    orientation[4 * row] = orientation[4 * row] * 10 + digit;
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("orientation", 4, VESPER_READ_WRITE, VESPER_UNIT_ONE)};
static vesper_law_desc laws[] = {
    LAW(NAME, PHASE, STAGES, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
static vesper_law_library library = {
    sizeof library, VESPER_ABI_VERSION, NAME, 1, 0, laws, NULL, NULL, 0, 0, NULL, NULL};

const vesper_law_library* vesper_law_library_entry(void) {
#ifdef FIRST_STAGE
  laws[0].first_stage = FIRST_STAGE;
#endif
  return &library;
}
