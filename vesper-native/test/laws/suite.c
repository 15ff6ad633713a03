// SPDX-License-Identifier: Apache-2.0
/* Two laws that share a counter of calls and log their creation and destruction. The parameter
 * of law `second` can make its creation fail. */
#define PARAMETER_COUNT 1
#include "test_law.h"

struct vesper_suite {
  const vesper_host* host;
  int calls;
};

static vesper_status Open(const vesper_host* host, vesper_suite** out, vesper_error* error) {
  vesper_suite* suite = calloc(1, sizeof *suite);
  if (suite == NULL) return Fail(error, VESPER_LAW_FAILED, "out of memory");
  suite->host = host;
  host->log(host->context, VESPER_LOG_INFO, "open");
  *out = suite;
  return VESPER_OK;
}

static void Close(vesper_suite* suite) {
  char line[64];
  snprintf(line, sizeof line, "close after %d calls", suite->calls);
  suite->host->log(suite->host->context, VESPER_LOG_INFO, line);
  free(suite);
}

static vesper_status CreateLogged(const vesper_host* host, vesper_suite* suite,
                                  const double* parameters, vesper_law** out, vesper_error* error) {
  if (parameters[0] == 1) return Fail(error, VESPER_LAW_FAILED, "asked to fail");
  host->log(host->context, VESPER_LOG_INFO, "create");
  return Create(host, suite, parameters, out, error);
}

static void DestroyLogged(vesper_law* law) {
  law->host->log(law->host->context, VESPER_LOG_INFO, "destroy");
  Destroy(law);
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)step;
  (void)error;
  ++law->suite->calls;
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};
static const vesper_parameter_desc kParameters[] = {PARAMETER("fail", VESPER_UNIT_ONE, 0, 0, 1)};
#define SUITE_LAW(name)     \
  {sizeof(vesper_law_desc), \
   VESPER_F64,              \
   name,                    \
   "1.0.0",                 \
   "Counts.",               \
   VESPER_PHASE_OBSERVE,    \
   0,                       \
   USE_COUNT,               \
   PARAMETER_COUNT,         \
   kUses,                   \
   kParameters,             \
   0,                       \
   0,                       \
   CreateLogged,            \
   Bind,                    \
   Act,                     \
   DestroyLogged,           \
   NULL,                    \
   NULL,                    \
   NULL,                    \
   0,                       \
   0}
static const vesper_law_desc kLaws[] = {SUITE_LAW("first"), SUITE_LAW("second")};
LIBRARY("suite", kLaws, Open, Close)
