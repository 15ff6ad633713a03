// SPDX-License-Identifier: Apache-2.0
/* Requests one property, given by the USE_… definitions, and does nothing with it. */
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  if (law->bound[0].data == NULL && law->bound[0].row_count == 0) return VESPER_OK;
  return EXPECT_ABSENT ? Fail(error, VESPER_LAW_FAILED, "the property is there") : VESPER_OK;
}

static const vesper_property_use kUses[] = {
    USE(USE_NAME, USE_KIND, USE_TYPE, USE_COMPONENTS, USE_ACCESS, USE_UNIT, USE_FLAGS)};
static const vesper_law_desc kLaws[] = {
    LAW("asking", USE_PHASE, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY("asking", kLaws, NULL, NULL)
