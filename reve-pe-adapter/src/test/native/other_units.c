// SPDX-License-Identifier: Apache-2.0
/* A law that wants the mass in metres. */
#include "test_law.h"

static const vesper_property_use kUses[] = {TEST_USE("mass", 1, VESPER_READ, VESPER_UNIT_METRE)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law, (void)step, (void)error;
  return VESPER_OK;
}

TEST_LIBRARY("other_units", "A law that wants the mass in metres.", VESPER_ABI_VERSION,
             .phase = VESPER_PHASE_OBSERVE)
