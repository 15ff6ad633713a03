// SPDX-License-Identifier: Apache-2.0
/* Writes a line to the log in each step. */
#include "test_law.h"

static const vesper_property_use kUses[] = {TEST_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  law->host->log(law->host->context, VESPER_LOG_WARNING, "greetings from a law");
  return VESPER_OK;
}

TEST_LIBRARY("greets", "Logs.", VESPER_ABI_VERSION, .phase = VESPER_PHASE_OBSERVE)
