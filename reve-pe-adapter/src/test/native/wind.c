// SPDX-License-Identifier: Apache-2.0
/* Pushes every body along X with a constant force. */
#include "test_law.h"

#ifndef WIND_FORCE
#define WIND_FORCE 1.0
#endif
#ifndef WIND_MOST
#define WIND_MOST 100
#endif
#ifndef WIND_CLAIMS
#define WIND_CLAIMS 0
#endif

static const vesper_property_use kUses[] = {
    TEST_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};

static const vesper_parameter_desc kParameters[] = {TEST_PARAMETER(
    "force", "Force along X.", VESPER_UNIT_NEWTON, WIND_FORCE, -WIND_MOST, WIND_MOST)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  double* force = law->properties[0].data;
  for (uint64_t i = 0; i < law->properties[0].row_count; ++i) force[3 * i] += law->parameter;
  return VESPER_OK;
}

TEST_LIBRARY("wind", "Constant force along X.", VESPER_ABI_VERSION, .phase = VESPER_PHASE_FORCE,
             .claims = WIND_CLAIMS, .parameter_count = 1, .parameters = kParameters)
