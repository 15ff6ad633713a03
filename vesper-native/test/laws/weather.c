// SPDX-License-Identifier: Apache-2.0
/* Provides the field `wind`, along x, with the suite's speed times the height. */
#define USE_COUNT 1
#include "test_law.h"

struct vesper_suite {
  double per_height;
};

static vesper_status Open(const vesper_host* host, vesper_suite** out, vesper_error* error) {
  static vesper_suite suite = {3};
  (void)host;
  (void)error;
  *out = &suite;
  return VESPER_OK;
}

static void Close(vesper_suite* suite) { (void)suite; }

static void Blow(void* user, uint64_t count, const double* at, double* out) {
  const vesper_suite* suite = user;
  for (uint64_t i = 0; i < count; ++i) {
    for (int c = 0; c < COMPONENTS; ++c) out[COMPONENTS * i + c] = 0;
#ifdef LOST
    out[COMPONENTS * i] = suite->per_height / (0 * at[3 * i + 1]);
#else
    out[COMPONENTS * i] = suite->per_height * at[3 * i + 1];
#endif
  }
}

static vesper_status Act(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law;
  (void)step;
  (void)error;
  return VESPER_OK;
}

static const vesper_property_use kUses[] = {REAL_USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM)};
static const vesper_law_desc kLaws[] = {
    LAW("weather", VESPER_PHASE_OBSERVE, 0, kUses, USE_COUNT, NULL, 0, Create, Bind, Act)};
static const vesper_field_desc kFields[] = {{sizeof(vesper_field_desc), COMPONENTS, "wind",
                                             "Blows along x.", FIELD_UNIT, Blow, NULL, NULL, NULL}};

const vesper_law_library* vesper_law_library_entry(void) {
  static const vesper_law_library library = {
      sizeof library, VESPER_ABI_VERSION, "weather", 1, 0, kLaws, Open, Close, 1, 0, kFields, NULL};
  return &library;
}
