// SPDX-License-Identifier: Apache-2.0
/* Sets TO to FROM plus 1 and logs this. Fails if its parameter requests it. Compile definitions:
 * NAME, FROM, TO and their units. */
#define USE_COUNT 2
#define PARAMETER_COUNT 1
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  const double* from = law->bound[0].data;
  double* to = law->bound[1].data;
  for (uint64_t i = 0; i < 3 * law->bound[0].row_count; ++i) to[i] = from[i] + 1;
  law->host->log(law->host->context, VESPER_LOG_INFO, "ran");
  if (law->parameters[0] == 1) return Fail(error, VESPER_LAW_FAILED, "asked to fail");
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {REAL_USE(FROM, 3, VESPER_READ, FROM_UNIT),
                                            REAL_USE(TO, 3, VESPER_WRITE, TO_UNIT)};
static const vesper_parameter_desc kParameters[] = {PARAMETER("fail", VESPER_UNIT_ONE, 0, 0, 1)};
static const vesper_law_desc kLaws[] = {LAW(NAME, VESPER_PHASE_OBSERVE, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY(NAME, kLaws, NULL, NULL)
