// SPDX-License-Identifier: Apache-2.0
// A minimal law: sets every acceleration to 2 m/s^2.
#include "vesper/law.h"

struct vesper_law {
  vesper_property acceleration;
};

namespace {

vesper_status Create(const vesper_host*, vesper_suite*, const double*, vesper_law** out,
                     vesper_error*) {
  *out = new vesper_law{};
  return VESPER_OK;
}

vesper_status Bind(vesper_law* law, const vesper_property* properties, vesper_error*) {
  law->acceleration = properties[0];
  return VESPER_OK;
}

vesper_status Advance(vesper_law* law, const vesper_step*, vesper_error*) {
  auto* a = static_cast<double*>(law->acceleration.data);
  for (uint64_t i = 0; i < 3 * law->acceleration.row_count; ++i) a[i] = 2;
  return VESPER_OK;
}

void Destroy(vesper_law* law) { delete law; }

constexpr vesper_property_use kUses[] = {{sizeof(vesper_property_use), VESPER_F64, "acceleration",
                                          "body", 3, VESPER_WRITE,
                                          VESPER_UNIT_METRE_PER_SECOND_SQUARED, 0, 0}};
constexpr vesper_law_desc kLaws[] = {{sizeof(vesper_law_desc),
                                      VESPER_F64,
                                      "outside",
                                      "1.0.0",
                                      "Sets accelerations.",
                                      VESPER_PHASE_OBSERVE,
                                      0,
                                      1,
                                      0,
                                      kUses,
                                      nullptr,
                                      0,
                                      0,
                                      Create,
                                      Bind,
                                      Advance,
                                      Destroy,
                                      nullptr,
                                      nullptr,
                                      nullptr}};
constexpr vesper_law_library kLibrary = {
    sizeof kLibrary, VESPER_ABI_VERSION, "outside", 1, 0, kLaws, nullptr, nullptr, 0, 0, nullptr,
    nullptr};

}  // namespace

const vesper_law_library* vesper_law_library_entry() { return &kLibrary; }
