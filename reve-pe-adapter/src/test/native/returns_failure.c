/* Pushes all bodies, then returns a failure that names a row, from step `from_step` on. */
#include <string.h>

#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};
TEST_BIND(kUses)

static const vesper_parameter_desc kParameters[] = {
    {sizeof(vesper_parameter_desc), 0, "from_step", "First bad step.", VESPER_UNIT_ONE, 0, 0, 1e9}};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  if ((double)step->index < law->parameter) return VESPER_OK;
  double* force = law->properties[0].data;
  for (uint64_t i = 0; i < 3 * law->properties[0].row_count; ++i) force[i] = 1e6;
  error->row = 0;
  strcpy(error->property, "externalForce");
  strcpy(error->message, "the bodies are too many for this law");
  return VESPER_LAW_FAILED;
}

static const vesper_law_desc kLaw = {.struct_size = sizeof kLaw,
                                     .real_type = VESPER_F64,
                                     .name = "returns_failure",
                                     .version = "1.0.0",
                                     .doc = "Fails from a step on.",
                                     .phase = VESPER_PHASE_FORCE,
                                     .use_count = TEST_USE_COUNT(kUses),
                                     .parameter_count = 1,
                                     .uses = kUses,
                                     .parameters = kParameters,
                                     .create = TestLawCreate,
                                     .bind = Bind,
                                     .advance = Advance,
                                     .destroy = TestLawDestroy};
TEST_LIBRARY("returns_failure", VESPER_ABI_VERSION, kLaw)
