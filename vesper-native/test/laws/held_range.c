// SPDX-License-Identifier: Apache-2.0
/* Runs ranges. The range with the number `held` ends only after all others. Fails if the others
 *  never end. */
#define _POSIX_C_SOURCE 200809L
#define PARAMETER_COUNT 2
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>

#include "test_law.h"

typedef struct {
  uint64_t held, ranges;
  time_t deadline;
  atomic_uint_fast64_t done;
  atomic_bool given_up;
} Loop;

static time_t Now(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec;
}

static void Range(void* user, uint64_t begin, uint64_t end) {
  Loop* loop = user;
  while (begin == loop->held && atomic_load(&loop->done) + 1 < loop->ranges) {
    if (Now() > loop->deadline) {
      atomic_store(&loop->given_up, true);
      break;
    }
    sched_yield();
  }
  atomic_fetch_add(&loop->done, end - begin);
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  Loop loop = {.held = (uint64_t)law->parameters[0],
               .ranges = (uint64_t)law->parameters[1],
               .deadline = Now() + 20};
  law->host->parallel_for(law->host->context, loop.ranges, 1, Range, &loop);
  if (atomic_load(&loop.given_up)) return Fail(error, VESPER_LAW_FAILED, "nobody did the others");
  if (atomic_load(&loop.done) != loop.ranges) {
    return Fail(error, VESPER_LAW_FAILED, "not each range was done once");
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("held", VESPER_UNIT_ONE, 0, 0, 1024),
    PARAMETER("ranges", VESPER_UNIT_ONE, 2, 1, 1024)};
static const vesper_law_desc kLaws[] = {LAW("held_range", VESPER_PHASE_FORCE, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY("held_range", kLaws, NULL, NULL)
