// SPDX-License-Identifier: Apache-2.0
/* Adds 1 N to the force on each body in a loop of "count" elements, in ranges of "grain". */
#define USE_COUNT 1
#define PARAMETER_COUNT 2
#include "test_law.h"

static void Range(void* user, uint64_t begin, uint64_t end) {
  const vesper_law* law = user;
  double* force = law->bound[0].data;
  for (uint64_t row = begin; row < end && row < law->bound[0].row_count; ++row) force[3 * row] += 1;
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  (void)error;
  law->host->parallel_for(law->host->context, (uint64_t)law->parameters[0],
                          (uint64_t)law->parameters[1], Range, law);
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("count", VESPER_UNIT_ONE, 0, 0, 1e19),
    PARAMETER("grain", VESPER_UNIT_ONE, 0, 0, 1e19)};
static const vesper_law_desc kLaws[] = {LAW("looping", VESPER_PHASE_FORCE, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY("looping", kLaws, NULL, NULL)
