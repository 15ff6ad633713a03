// SPDX-License-Identifier: Apache-2.0
/* Behaves until step `from_step`, then spoils all positions and writes NaN to the last velocity. */
#include <math.h>

#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
    TEST_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};

static const vesper_parameter_desc kParameters[] = {
    TEST_PARAMETER("from_step", "First bad step.", VESPER_UNIT_ONE, 0, 0, 1e9)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)error;
  if ((double)step->index < law->parameter) return VESPER_OK;
  double* position = law->properties[0].data;
  double* velocity = law->properties[1].data;
  const uint64_t rows = law->properties[0].row_count;
  for (uint64_t i = 0; i < 3 * rows; ++i) position[i] = -1;
  velocity[3 * rows - 2] = NAN;
  return VESPER_OK;
}

TEST_LIBRARY("writes_nan", "Writes NaN from a step on.", VESPER_ABI_VERSION,
             .phase = VESPER_PHASE_CONSTRAIN, .parameter_count = 1, .parameters = kParameters)
