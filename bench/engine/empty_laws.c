// SPDX-License-Identifier: Apache-2.0
/* A library of LAWS force laws with an empty body. The time of a step with them is the cost of the
 * engine. */
#include "vesper/law.h"

#define USE(property, components_, access_, unit_) \
  {.struct_size = sizeof(vesper_property_use),     \
   .scalar_type = VESPER_F64,                      \
   .name = property,                               \
   .kind = "body",                                 \
   .components = components_,                      \
   .access = access_,                              \
   .unit = unit_}

static const vesper_property_use kUses[] = {
    USE("mass", 1, VESPER_READ, VESPER_UNIT_KILOGRAM),
    USE("position", 3, VESPER_READ, VESPER_UNIT_METRE),
    USE("velocity", 3, VESPER_READ, VESPER_UNIT_METRE_PER_SECOND),
    USE("externalForce", 3, VESPER_ACCUMULATE, VESPER_UNIT_NEWTON)};

static vesper_status Create(const vesper_host* host, vesper_suite* suite, const double* parameters,
                            vesper_law** out, vesper_error* error) {
  static char nothing;
  (void)host, (void)suite, (void)parameters, (void)error;
  *out = (vesper_law*)&nothing;
  return VESPER_OK;
}

static vesper_status Bind(vesper_law* law, const vesper_property* properties, vesper_error* error) {
  (void)law, (void)properties, (void)error;
  return VESPER_OK;
}

static vesper_status Advance(vesper_law* law, const vesper_step* step, vesper_error* error) {
  (void)law, (void)step, (void)error;
  return VESPER_OK;
}

static void Destroy(vesper_law* law) { (void)law; }

const vesper_law_library* vesper_law_library_entry(void) {
  static char names[LAWS][16];
  static vesper_law_desc laws[LAWS];
  static vesper_law_library library;
  for (uint32_t i = 0; i < LAWS; ++i) {
    const char name[] = {'e', 'm', 'p', 't', 'y', '_', (char)('0' + i / 10), (char)('0' + i % 10)};
    for (uint32_t k = 0; k < sizeof name; ++k) names[i][k] = name[k];
    laws[i] = (vesper_law_desc){.struct_size = sizeof(vesper_law_desc),
                                .real_type = VESPER_F64,
                                .name = names[i],
                                .version = "1.0.0",
                                .doc = "Does nothing.",
                                .phase = VESPER_PHASE_FORCE,
                                .use_count = sizeof kUses / sizeof *kUses,
                                .uses = kUses,
                                .create = Create,
                                .bind = Bind,
                                .advance = Advance,
                                .destroy = Destroy};
  }
  library = (vesper_law_library){.struct_size = sizeof library,
                                 .abi_version = VESPER_ABI_VERSION,
                                 .name = "empty_laws",
                                 .law_count = LAWS,
                                 .laws = laws};
  return &library;
}
