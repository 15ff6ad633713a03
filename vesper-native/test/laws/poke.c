// SPDX-License-Identifier: Apache-2.0
/* Writes one of kValues to one number of one property. The columns of the world tell it where: the
 * property `gravity` contains the property's index in kUses after the first, the row, and the index
 * in kValues. The component is the row modulo the number of components. */
#define USE_COUNT 6
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  static const double kValues[] = {NAN, HUGE_VAL, -HUGE_VAL, 0x1p333, 1e38, -0.0, 0x1p-1074};
  const double* poke = law->bound[0].data;
  double* acceleration = law->bound[5].data;
  for (uint64_t i = 0; i < 3 * law->bound[5].row_count; ++i) acceleration[i] = 1;
  const vesper_property* property = &law->bound[1 + (int)poke[0]];
  const uint64_t row = (uint64_t)poke[1];
  double* values = property->data;
  values[property->components * row + row % property->components] = kValues[(int)poke[2]];
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    USE("gravity", "world", VESPER_F64, 3, VESPER_READ, VESPER_UNIT_METRE_PER_SECOND_SQUARED, 0),
    REAL_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
    REAL_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND),
    REAL_USE("orientation", 4, VESPER_READ_WRITE, VESPER_UNIT_ONE),
    REAL_USE("angularVelocity", 3, VESPER_READ_WRITE, VESPER_UNIT_RADIAN_PER_SECOND),
    REAL_USE("acceleration", 3, VESPER_WRITE, VESPER_UNIT_METRE_PER_SECOND_SQUARED),
};
static const vesper_law_desc kLaws[] = {
    LAW("poke", VESPER_PHASE_CONSTRAIN, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY("poke", kLaws, NULL, NULL)
