// SPDX-License-Identifier: Apache-2.0
/* Pushes all bodies, then returns a failure that names a row, from step `from_step` on. */
#include <string.h>

#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};

static const vesper_parameter_desc kParameters[] = {
    TEST_PARAMETER("from_step", "First bad step.", VESPER_UNIT_ONE, 0, 0, 1e9)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  if ((double)step->index < law->parameter) return VESPER_OK;
  double* force = law->properties[0].data;
  for (uint64_t i = 0; i < 3 * law->properties[0].row_count; ++i) force[i] = 1e6;
  error->row = 0;
  strcpy(error->property, "externalForce");
  strcpy(error->message, "the bodies are too many for this law");
  return VESPER_LAW_FAILED;
}

TEST_LIBRARY("returns_failure", "Fails from a step on.", VESPER_ABI_VERSION,
             .phase = VESPER_PHASE_FORCE, .parameter_count = 1, .parameters = kParameters)
