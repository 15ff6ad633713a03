// SPDX-License-Identifier: Apache-2.0
/* Pulls the ends of every spring together with the force hookeConstant. This shows the rows and
 * values that the law received. Logs each bind. */
#define USE_COUNT 3
#include "test_law.h"

static vesper_status BindLogged(vesper_law* law, const vesper_property* properties,
                                vesper_error* error) {
  char line[64];
  snprintf(line, sizeof line, "bind %llu springs", (unsigned long long)properties[0].row_count);
  law->host->log(law->host->context, VESPER_LOG_INFO, line);
  return Bind(law, properties, error);
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  (void)error;
  const uint32_t* endpoints = law->bound[0].data;
  const double* hooke = law->bound[1].data;
  double* force = law->bound[2].data;
  for (uint64_t row = 0; row < law->bound[0].row_count; ++row) {
    force[3 * endpoints[2 * row]] += hooke[row];
    force[3 * endpoints[2 * row + 1]] -= hooke[row];
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    USE("endpoints", "spring", VESPER_U32, 2, VESPER_READ, VESPER_UNIT_ONE, 0),
    USE("hookeConstant", "spring", VESPER_F64, 1, VESPER_READ, VESPER_UNIT_NEWTON_PER_METRE, 0),
    REAL_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON),
};
static const vesper_law_desc kLaws[] = {
    LAW("springs", VESPER_PHASE_FORCE, 0, kUses, USE_COUNT, NULL, 0, Create, BindLogged, Act)};
LIBRARY("springs", kLaws, NULL, NULL)
