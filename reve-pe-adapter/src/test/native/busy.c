// SPDX-License-Identifier: Apache-2.0
/* Uses a processor for a time in each step: `milliseconds` of processor time. Exerts no force. */
#define _GNU_SOURCE
#include <time.h>

#include "test_law.h"

static const vesper_property_use kUses[] = {
    TEST_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};

static const vesper_parameter_desc kParameters[] = {
    TEST_PARAMETER("milliseconds", "Processor time of a step [ms].", VESPER_UNIT_ONE, 1, 0, 1000)};

static double Milliseconds(void) {
  struct timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step, (void)error;
  const double end = Milliseconds() + law->parameter;
  while (Milliseconds() < end) {
  }
  return VESPER_OK;
}

TEST_LIBRARY("busy", "Uses a processor.", VESPER_ABI_VERSION, .phase = VESPER_PHASE_FORCE,
             .parameter_count = 1, .parameters = kParameters)
