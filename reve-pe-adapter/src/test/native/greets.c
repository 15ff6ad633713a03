/* Writes a line to the log in each step. */
#include "test_law.h"

static const vesper_host* the_host;

static vesper_status Create(const vesper_host* host, vesper_suite* suite, const double* parameters,
                            vesper_law** out, vesper_error* error) {
  the_host = host;
  return TestLawCreate(host, suite, parameters, out, error);
}

static const vesper_property_use kUses[] = {
    TEST_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};
TEST_BIND(kUses)

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law, (void)step, (void)error;
  the_host->log(the_host->context, VESPER_LOG_WARNING, "greetings from a law");
  return VESPER_OK;
}

static const vesper_law_desc kLaw = {.struct_size = sizeof kLaw,
                                     .real_type = VESPER_F64,
                                     .name = "greets",
                                     .version = "1.0.0",
                                     .doc = "Logs.",
                                     .phase = VESPER_PHASE_OBSERVE,
                                     .use_count = TEST_USE_COUNT(kUses),
                                     .uses = kUses,
                                     .create = Create,
                                     .bind = Bind,
                                     .advance = Advance,
                                     .destroy = TestLawDestroy};
TEST_LIBRARY("greets", VESPER_ABI_VERSION, kLaw)
