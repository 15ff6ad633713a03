/* A second integrator of velocity, which cannot live beside newton_motion. Stops all bodies. */
#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("velocity", 3, VESPER_READ_WRITE, VESPER_UNIT_METRE_PER_SECOND)};
TEST_BIND(kUses)

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  double* velocity = law->properties[0].data;
  for (uint64_t i = 0; i < 3 * law->properties[0].row_count; ++i) velocity[i] = 0;
  return VESPER_OK;
}

static const vesper_law_desc kLaw = {.struct_size = sizeof kLaw,
                                     .real_type = VESPER_F64,
                                     .name = "rival_motion",
                                     .version = "1.0.0",
                                     .doc = "Stops all bodies.",
                                     .phase = VESPER_PHASE_INTEGRATE,
                                     .stages = 1,
                                     .use_count = TEST_USE_COUNT(kUses),
                                     .uses = kUses,
                                     .create = TestLawCreate,
                                     .bind = Bind,
                                     .advance = Advance,
                                     .destroy = TestLawDestroy};
TEST_LIBRARY("rival_motion", VESPER_ABI_VERSION, kLaw)
