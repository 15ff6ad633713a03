// SPDX-License-Identifier: Apache-2.0
/* Violates the rule selected by its parameter `mode`, at the row given by `row`. */
#define USE_COUNT 3
#define PARAMETER_COUNT 2
#include "misbehaving.h"
#include "test_law.h"

#if defined(__x86_64__)
#include <immintrin.h>
static void ChangeFloatingPointModes(void) { _mm_setcsr(_mm_getcsr() | 0x8040 | 0x6000); }
#else
#include <fenv.h>
static void ChangeFloatingPointModes(void) { fesetround(FE_UPWARD); }
#endif

static vesper_status CreateOrFail(const vesper_host* host, vesper_suite* suite,
                                  const double* parameters, vesper_law** out, vesper_error* error) {
  if (parameters[0] == FAIL_IN_CREATE) return Fail(error, VESPER_LAW_FAILED, "no device");
  if (parameters[0] == NO_LAW_FROM_CREATE) return VESPER_OK;
  return Create(host, suite, parameters, out, error);
}

static vesper_status BindOrFail(vesper_law* law, const vesper_property* properties,
                                vesper_error* error) {
  if (law->parameters[0] == FAIL_IN_BIND) return Fail(error, VESPER_INTERNAL, "no room");
  if (law->parameters[0] == WRITE_READ_COLUMN_IN_BIND) ((double*)properties[0].data)[0] += 1;
  return Bind(law, properties, error);
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  double* mass = law->bound[0].data;
  double* position = law->bound[1].data;
  double* acceleration = law->bound[2].data;
  const uint64_t rows = law->bound[0].row_count;
  const uint64_t row = (uint64_t)law->parameters[1];
  const int mode = (int)law->parameters[0];
  for (uint64_t i = 0; i < rows; ++i) {
    if (mode == LEAVE_ROW_UNWRITTEN && i == row) continue;
    for (int c = 0; c < 3; ++c) acceleration[3 * i + c] = 1;
  }
  switch (mode) {
    case WRITE_NAN:
      position[3 * row + 1] = NAN;
      break;
    case WRITE_INFINITY:
      position[3 * row + 2] = -HUGE_VAL;
      break;
    case WRITE_READ_COLUMN:
      mass[row] += 1;
      break;
    case WRITE_PAST_END:
      position[3 * rows] = 1;
      break;
    case WRITE_BEFORE_START:
      position[-1] = 1;
      break;
    case CHANGE_MODES:
      ChangeFloatingPointModes();
      break;
    case FAIL_WITH_MESSAGE:
      return Fail(error, VESPER_LAW_FAILED, "diverged\nat once");
    case FAIL_WITHOUT_MESSAGE:
      return VESPER_NOT_FOUND;
    case FAIL_WITH_ROW:
      error->row = row;
      strcpy(error->property, "position");
      return Fail(error, VESPER_LAW_FAILED, "too fast");
    default:
      break;
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    REAL_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
    REAL_USE("acceleration", 3, VESPER_WRITE, VESPER_UNIT_METRE_PER_SECOND_SQUARED),
};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("mode", VESPER_UNIT_ONE, WELL_BEHAVED, 0, 1000),
    PARAMETER("row", VESPER_UNIT_ONE, 0, 0, 1e6),
};
static const vesper_law_desc kLaws[] = {LAW("misbehaving", VESPER_PHASE_CONSTRAIN, 0, kUses,
                                            USE_COUNT, kParameters, PARAMETER_COUNT, CreateOrFail,
                                            BindOrFail, Act)};
LIBRARY("misbehaving", kLaws, NULL, NULL)
