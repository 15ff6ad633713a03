// SPDX-License-Identifier: Apache-2.0
/* Moves every body with the field `wind`, which it evaluates in one call. */
#define USE_COUNT 3
#include "test_law.h"

#if PER_HOUR
#define SPEED VESPER_UNIT_INIT(1, 0, -1, 0, 0, 0, 0, 1.0 / 3600, "m/h")
#else
#define SPEED VESPER_UNIT_METRE_PER_SECOND
#endif

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  const vesper_field* wind = law->bound[0].data;
  (void)step;
  if (law->bound[0].row_count != 0) return Fail(error, VESPER_LAW_FAILED, "a field has rows");
  wind->evaluate(wind->user, law->bound[1].row_count, law->bound[1].data, law->bound[2].data);
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    USE("wind", "world", VESPER_FIELD, 3, VESPER_READ, SPEED, 0),
    REAL_USE("position", 3, VESPER_READ, VESPER_UNIT_METRE),
    REAL_USE("velocity", 3, VESPER_WRITE, SPEED),
};
static const vesper_law_desc kLaws[] = {
    LAW("windy", VESPER_PHASE_CONSTRAIN, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY("windy", kLaws, NULL, NULL)
