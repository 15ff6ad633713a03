/* Behaves until step `from_step`, then spoils all positions and writes NaN to the last velocity. */
#include <math.h>

#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("position", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE),
    TEST_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};
TEST_BIND(kUses)

static const vesper_parameter_desc kParameters[] = {
    {sizeof(vesper_parameter_desc), 0, "from_step", "First bad step.", VESPER_UNIT_ONE, 0, 0, 1e9}};

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

static const vesper_law_desc kLaw = {.struct_size = sizeof kLaw,
                                     .real_type = VESPER_F64,
                                     .name = "writes_nan",
                                     .version = "1.0.0",
                                     .doc = "Writes NaN from a step on.",
                                     .phase = VESPER_PHASE_CONSTRAIN,
                                     .use_count = TEST_USE_COUNT(kUses),
                                     .parameter_count = 1,
                                     .uses = kUses,
                                     .parameters = kParameters,
                                     .create = TestLawCreate,
                                     .bind = Bind,
                                     .advance = Advance,
                                     .destroy = TestLawDestroy};
TEST_LIBRARY("writes_nan", VESPER_ABI_VERSION, kLaw)
