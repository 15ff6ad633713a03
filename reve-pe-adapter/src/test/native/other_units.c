/* A law that wants the mass in metres. */
#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("mass", 1, VESPER_READ, VESPER_UNIT_METRE)};
TEST_BIND(kUses)

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law, (void)step, (void)error;
  return VESPER_OK;
}

static const vesper_law_desc kLaw = {.struct_size = sizeof kLaw,
                                     .real_type = VESPER_F64,
                                     .name = "other_units",
                                     .version = "1.0.0",
                                     .doc = "A law that wants the mass in metres.",
                                     .phase = VESPER_PHASE_OBSERVE,
                                     .use_count = TEST_USE_COUNT(kUses),
                                     .uses = kUses,
                                     .create = TestLawCreate,
                                     .bind = Bind,
                                     .advance = Advance,
                                     .destroy = TestLawDestroy};
TEST_LIBRARY("other_units", VESPER_ABI_VERSION, kLaw)
