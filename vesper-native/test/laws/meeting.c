// SPDX-License-Identifier: Apache-2.0
/* Laws that synchronize if they run concurrently. Each law writes a byte to the pipe `tell` and
 * waits `patience` seconds for a byte from the pipe `hear`. It fails if no byte arrives. The
 * library's second law does the same over its own pipes. Compile definitions: NAME, PROPERTY,
 * ACCESS, UNIT and PHASE. */
#define PARAMETER_COUNT 3
#include <poll.h>
#include <unistd.h>

#include "test_law.h"

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  if (ACCESS == VESPER_WRITE) {
    memset(law->bound[0].data, 0, 3 * sizeof(double) * law->bound[0].row_count);
  }
  if (law->parameters[0] == 0) return VESPER_OK;
  char byte = 'x';
  if (write((int)law->parameters[0], &byte, 1) != 1) {
    return Fail(error, VESPER_LAW_FAILED, "cannot tell");
  }
  struct pollfd hear = {.fd = (int)law->parameters[1], .events = POLLIN};
  if (poll(&hear, 1, (int)(1000 * law->parameters[2])) != 1 || read(hear.fd, &byte, 1) != 1) {
    return Fail(error, VESPER_LAW_FAILED, "nobody came");
  }
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {REAL_USE(PROPERTY, 3, ACCESS, UNIT)};
static const vesper_property_use kNoUses[] = {
    REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};
static const vesper_parameter_desc kParameters[] = {
    PARAMETER("tell", VESPER_UNIT_ONE, 0, 0, 1e6), PARAMETER("hear", VESPER_UNIT_ONE, 0, 0, 1e6),
    PARAMETER("patience", VESPER_UNIT_SECOND, 0, 0, 60)};
static const vesper_law_desc kLaws[] = {
    LAW("first", PHASE, 0, kUses, USE_COUNT, kParameters, PARAMETER_COUNT, Create, Bind, Act),
    LAW("second", VESPER_PHASE_OBSERVE, 0, kNoUses, USE_COUNT, kParameters, PARAMETER_COUNT, Create,
        Bind, Act)};
LIBRARY(NAME, kLaws, NULL, NULL)
