// SPDX-License-Identifier: Apache-2.0
/* Writes NaN or infinity to one number of one property in each step. */
#include <math.h>

#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
    TEST_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND),
    TEST_USE("orientation", 4, VESPER_READ_WRITE, VESPER_UNIT_ONE),
    TEST_USE("angularVelocity", 3, VESPER_READ_WRITE, VESPER_UNIT_RADIAN_PER_SECOND)};

static const vesper_parameter_desc kParameters[] = {
    TEST_PARAMETER("place", "Row * 12 + property * 3 + value: NaN, infinity or -infinity.",
                   VESPER_UNIT_ONE, 0, 0, 1e9)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  static const double kValues[] = {NAN, HUGE_VAL, -HUGE_VAL};
  const uint64_t place = (uint64_t)law->parameter;
  const vesper_property* property = &law->properties[place / 3 % 4];
  double* values = property->data;
  values[place / 12 * property->components] = kValues[place % 3];
  return VESPER_OK;
}

TEST_LIBRARY("writes_extreme", "Writes NaN or infinity.", VESPER_ABI_VERSION,
             .phase = VESPER_PHASE_CONSTRAIN, .parameter_count = 1, .parameters = kParameters)
