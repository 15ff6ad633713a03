// SPDX-License-Identifier: Apache-2.0
/* A second integrator of velocity, which cannot live beside newton_motion. Stops all bodies. */
#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  double* velocity = law->properties[0].data;
  for (uint64_t i = 0; i < 3 * law->properties[0].row_count; ++i) velocity[i] = 0;
  return VESPER_OK;
}

TEST_LIBRARY("rival_motion", "Stops all bodies.", VESPER_ABI_VERSION,
             .phase = VESPER_PHASE_INTEGRATE, .stages = 1)
