// SPDX-License-Identifier: Apache-2.0
/* Changes its tables as soon as it is loaded. */
#define USE_COUNT 1
#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law;
  (void)step;
  (void)error;
  return VESPER_OK;
}

static vesper_status ChangeMind(const vesper_host* host, vesper_suite* suite,
                                const double* parameters, vesper_law** out, vesper_error* error);

static vesper_property_use uses[] = {REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};
static vesper_law_desc laws[] = {
    LAW("fickle", VESPER_PHASE_OBSERVE, 0, uses, USE_COUNT, NULL, 0, ChangeMind, Bind, Act)};

static vesper_status ChangeMind(const vesper_host* host, vesper_suite* suite,
                                const double* parameters, vesper_law** out, vesper_error* error) {
  uses[0].name = "velocity";
  uses[0].components = 3;
  uses[0].access = VESPER_WRITE;
  laws[0].use_count = 0;
  laws[0].phase = VESPER_PHASE_FORCE;
  return Create(host, suite, parameters, out, error);
}

LIBRARY("fickle", laws, NULL, NULL)
