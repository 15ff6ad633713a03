// SPDX-License-Identifier: Apache-2.0
/* The common parts of the test laws. They are a law without private data, a way to list a property,
 *  and the table. */
#ifndef REVE_TEST_LAW_H_
#define REVE_TEST_LAW_H_

#include <stddef.h>

#include "vesper/law.h"

/* The law is its host, its bound arrays and its first parameter. A test loads each library once. */
struct vesper_law {
  const vesper_host* host;
  vesper_property properties[4];
  double parameter;
};

static struct vesper_law the_law;

static vesper_status TestLawCreate(const vesper_host* host, vesper_suite* suite,
                                   const double* parameters, vesper_law** out,
                                   vesper_error* error) {
  (void)suite, (void)error;
  the_law.host = host;
  the_law.parameter = parameters != NULL ? parameters[0] : 0;
  *out = &the_law;
  return VESPER_OK;
}

static void TestLawDestroy(vesper_law* law) { (void)law; }

#define TEST_USE(name, components, access, unit) \
  {sizeof(vesper_property_use), VESPER_F64, name, "body", components, access, unit, 0, 0}

#define TEST_USE_COUNT(uses) (sizeof(uses) / sizeof((uses)[0]))

#define TEST_PARAMETER(name, doc, unit, value, minimum, maximum) \
  {sizeof(vesper_parameter_desc), 0, name, doc, unit, value, minimum, maximum}

/* A library of one law. The library and the law have the same name. The law has the uses kUses and
 * runs Advance. The designated initialisers at the end set its other fields. */
#define TEST_LIBRARY(law_name, law_doc, abi, ...)                                          \
  static vesper_status Bind(vesper_law* law, const vesper_property* properties,            \
                            vesper_error* error) {                                         \
    (void)error;                                                                           \
    for (size_t i = 0; i < TEST_USE_COUNT(kUses); ++i) law->properties[i] = properties[i]; \
    return VESPER_OK;                                                                      \
  }                                                                                        \
  const vesper_law_library* vesper_law_library_entry(void) {                               \
    static const vesper_law_desc kLaw = {.struct_size = sizeof kLaw,                       \
                                         .real_type = VESPER_F64,                          \
                                         .name = law_name,                                 \
                                         .version = "1.0.0",                               \
                                         .doc = law_doc,                                   \
                                         .use_count = TEST_USE_COUNT(kUses),               \
                                         .uses = kUses,                                    \
                                         .create = TestLawCreate,                          \
                                         .bind = Bind,                                     \
                                         .advance = Advance,                               \
                                         .destroy = TestLawDestroy,                        \
                                         __VA_ARGS__};                                     \
    static const vesper_law_library kLibrary = {.struct_size = sizeof kLibrary,            \
                                                .abi_version = abi,                        \
                                                .name = law_name,                          \
                                                .law_count = 1,                            \
                                                .laws = &kLaw};                            \
    return &kLibrary;                                                                      \
  }

#endif
