// SPDX-License-Identifier: Apache-2.0
/* Common code of all test laws. A law keeps its host, its parameters and its bound arrays.
 *
 * A law file defines USE_COUNT, PARAMETER_COUNT and a function `Act`, then lists its tables.
 * Compile definitions vary names and behaviour, so that one file makes several libraries.
 */
#ifndef TEST_LAW_H_
#define TEST_LAW_H_

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vesper/law.h"

#ifndef USE_COUNT
#define USE_COUNT 1
#endif
#ifndef PARAMETER_COUNT
#define PARAMETER_COUNT 0
#endif

struct vesper_law {
  const vesper_host* host;
  vesper_suite* suite;
  double parameters[PARAMETER_COUNT + 1];
  vesper_property bound[USE_COUNT + 1];
};

static inline vesper_status Fail(vesper_error* error, vesper_status status, const char* message) {
  snprintf(error->message, sizeof error->message, "%s", message);
  return status;
}

static inline vesper_status Create(const vesper_host* host, vesper_suite* suite,
                                   const double* parameters, vesper_law** out,
                                   vesper_error* error) {
  vesper_law* law = calloc(1, sizeof *law);
  if (law == NULL) return Fail(error, VESPER_LAW_FAILED, "out of memory");
  law->host = host;
  law->suite = suite;
  memcpy(law->parameters, parameters, PARAMETER_COUNT * sizeof *parameters);
  *out = law;
  return VESPER_OK;
}

static inline vesper_status Bind(vesper_law* law, const vesper_property* properties,
                                 vesper_error* error) {
  (void)error;
  memcpy(law->bound, properties, USE_COUNT * sizeof *properties);
  return VESPER_OK;
}

static inline void Destroy(vesper_law* law) { free(law); }

#define USE(name, kind, type, components, access, unit, flags) \
  {sizeof(vesper_property_use), type, name, kind, components, access, unit, flags, 0}
#define REAL_USE(name, components, access, unit) \
  {sizeof(vesper_property_use), VESPER_F64, name, "body", components, access, unit, 0, 0}
#define PARAMETER(name, unit, value, minimum, maximum) \
  {sizeof(vesper_parameter_desc), 0, name, "A parameter.", unit, value, minimum, maximum}
#define LAW(name, phase, stages, uses, use_count, parameters, parameter_count, create, bind, act) \
  {sizeof(vesper_law_desc),                                                                       \
   VESPER_F64,                                                                                    \
   name,                                                                                          \
   "1.0.0",                                                                                       \
   "A test law.",                                                                                 \
   phase,                                                                                         \
   stages,                                                                                        \
   use_count,                                                                                     \
   parameter_count,                                                                               \
   uses,                                                                                          \
   parameters,                                                                                    \
   0,                                                                                             \
   0,                                                                                             \
   create,                                                                                        \
   bind,                                                                                          \
   act,                                                                                           \
   Destroy,                                                                                       \
   NULL,                                                                                          \
   NULL,                                                                                          \
   NULL,                                                                                          \
   0,                                                                                             \
   0}
#define LIBRARY(name, laws, open, close)                                   \
  const vesper_law_library* vesper_law_library_entry(void) {               \
    static const vesper_law_library library = {sizeof library,             \
                                               VESPER_ABI_VERSION,         \
                                               name,                       \
                                               sizeof laws / sizeof *laws, \
                                               0,                          \
                                               laws,                       \
                                               open,                       \
                                               close,                      \
                                               0,                          \
                                               0,                          \
                                               NULL,                       \
                                               NULL};                      \
    return &library;                                                       \
  }

#endif /* TEST_LAW_H_ */
