// SPDX-License-Identifier: Apache-2.0
/* Remembers how many steps each body has seen, and shows it as its speed along X. */
#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("age", 1, VESPER_SCRATCH, VESPER_UNIT_ONE),
    TEST_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  double* age = law->properties[0].data;
  double* velocity = law->properties[1].data;
  for (uint64_t i = 0; i < law->properties[0].row_count; ++i) velocity[3 * i] = ++age[i];
  return VESPER_OK;
}

TEST_LIBRARY("counts_years", "Steps that a body has seen.", VESPER_ABI_VERSION,
             .phase = VESPER_PHASE_OBSERVE)
