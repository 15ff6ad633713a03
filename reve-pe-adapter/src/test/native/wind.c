/* Pushes every body along X with a constant force. */
#include "test_law.h"

#ifndef WIND_FORCE
#define WIND_FORCE 1.0
#endif

static const vesper_property_use kUses[] = {
    TEST_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};
TEST_BIND(kUses)

static const vesper_parameter_desc kParameters[] = {
    {sizeof(vesper_parameter_desc), 0, "force", "Force along X.", VESPER_UNIT_NEWTON, WIND_FORCE,
     -100, 100}};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  double* force = law->properties[0].data;
  for (uint64_t i = 0; i < law->properties[0].row_count; ++i) force[3 * i] += law->parameter;
  return VESPER_OK;
}

static const vesper_law_desc kLaw = {.struct_size = sizeof kLaw,
                                     .real_type = VESPER_F64,
                                     .name = "wind",
                                     .version = "1.0.0",
                                     .doc = "Constant force along X.",
                                     .phase = VESPER_PHASE_FORCE,
                                     .use_count = TEST_USE_COUNT(kUses),
                                     .parameter_count = 1,
                                     .uses = kUses,
                                     .parameters = kParameters,
                                     .create = TestLawCreate,
                                     .bind = Bind,
                                     .advance = Advance,
                                     .destroy = TestLawDestroy};
TEST_LIBRARY("wind", VESPER_ABI_VERSION, kLaw)
