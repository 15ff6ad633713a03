// SPDX-License-Identifier: Apache-2.0
/* Runs ranges that wait until `seats` of them run concurrently. Fails if this never happens. */
#define _POSIX_C_SOURCE 200809L
#define PARAMETER_COUNT 1
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>

#include "test_law.h"

typedef struct {
  uint64_t seats;
  time_t deadline;
  atomic_uint_fast64_t taken;
  atomic_bool given_up;
} Table;

static time_t Now(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec;
}

static void Sit(void* user, uint64_t begin, uint64_t end) {
  Table* table = user;
  atomic_fetch_add(&table->taken, end - begin);
  while (atomic_load(&table->taken) < table->seats && !atomic_load(&table->given_up)) {
    if (Now() > table->deadline) atomic_store(&table->given_up, true);
    sched_yield();
  }
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  Table table = {.seats = (uint64_t)law->parameters[0], .deadline = Now() + 20};
  law->host->parallel_for(law->host->context, table.seats, 1, Sit, &table);
  if (atomic_load(&table.given_up)) return Fail(error, VESPER_LAW_FAILED, "seats stayed empty");
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {
    REAL_USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};
static const vesper_parameter_desc kParameters[] = {PARAMETER("seats", VESPER_UNIT_ONE, 1, 1, 256)};
static const vesper_law_desc kLaws[] = {LAW("rendezvous", VESPER_PHASE_FORCE, 0, kUses, USE_COUNT,
                                            kParameters, PARAMETER_COUNT, Create, Bind, Act)};
LIBRARY("rendezvous", kLaws, NULL, NULL)
