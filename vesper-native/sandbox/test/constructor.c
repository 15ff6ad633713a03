// SPDX-License-Identifier: Apache-2.0
/* A law whose static constructor does what no library may do. Compile definition: ACT. */
#include <fcntl.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include "test_law.h"

static int succeeded = 0;

__attribute__((constructor)) static void Construct(void) {
  if (ACT == 0)
    succeeded = open("/etc/passwd", O_RDONLY) >= 0 || open("/proc/1/mem", O_RDONLY) >= 0;
  if (ACT == 1) succeeded = socket(AF_UNIX, SOCK_STREAM, 0) >= 0;
  if (ACT == 2) _exit(0);
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law;
  (void)step;
  return succeeded ? Fail(error, VESPER_LAW_FAILED, "succeeded") : VESPER_OK;
}

static const vesper_property_use kUses[] = {REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};
static const vesper_law_desc kLaws[] = {
    LAW("constructor", VESPER_PHASE_OBSERVE, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
LIBRARY("constructor", kLaws, NULL, NULL)
