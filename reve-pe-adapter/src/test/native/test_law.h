/* What the test laws share: a law without private data, and how to list a property. */
#ifndef REVE_TEST_LAW_H_
#define REVE_TEST_LAW_H_

#include <stddef.h>

#include "vesper/law.h"

/* The law is its bound arrays and its first parameter. A test loads each library once. */
struct vesper_law {
  vesper_property properties[4];
  double parameter;
};

static struct vesper_law the_law;

static vesper_status TestLawCreate(const vesper_host* host, vesper_suite* suite,
                                   const double* parameters, vesper_law** out,
                                   vesper_error* error) {
  (void)host, (void)suite, (void)error;
  the_law.parameter = parameters != NULL ? parameters[0] : 0;
  *out = &the_law;
  return VESPER_OK;
}

static void TestLawDestroy(vesper_law* law) { (void)law; }

#define TEST_USE(name, components, access, unit)                                               \
  {sizeof(vesper_property_use), VESPER_F64, name, "body", components, access, unit, 0, 0}

#define TEST_USE_COUNT(uses) (sizeof(uses) / sizeof((uses)[0]))

#define TEST_BIND(uses)                                                                        \
  static vesper_status Bind(vesper_law* law, const vesper_property* properties,                \
                            vesper_error* error) {                                             \
    (void)error;                                                                               \
    for (size_t i = 0; i < TEST_USE_COUNT(uses); ++i) law->properties[i] = properties[i];      \
    return VESPER_OK;                                                                          \
  }

#define TEST_LIBRARY(library_name, abi, law)                                                   \
  const vesper_law_library* vesper_law_library_entry(void) {                                   \
    static const vesper_law_library kLibrary = {                                               \
        .struct_size = sizeof kLibrary, .abi_version = abi, .name = library_name,              \
        .law_count = 1, .laws = &law};                                                         \
    return &kLibrary;                                                                          \
  }

#endif
