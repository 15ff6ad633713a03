// SPDX-License-Identifier: Apache-2.0
// Throws an exception from `advance`, which is forbidden.
#include <stdexcept>

#include "vesper/law.h"

struct vesper_law {};

namespace {

vesper_status Create(const vesper_host*, vesper_suite*, const double*, vesper_law** out,
                     vesper_error*) {
  *out = new vesper_law;
  return VESPER_OK;
}

vesper_status Bind(vesper_law*, const vesper_property*, vesper_error*) { return VESPER_OK; }

vesper_status Advance(vesper_law*, const vesper_step*, vesper_error*) {
  throw std::runtime_error("out of range");
}

void Destroy(vesper_law* law) { delete law; }

constexpr vesper_law_desc kLaw = {sizeof(vesper_law_desc),
                                  0,
                                  "throwing",
                                  "1.0.0",
                                  "A test law.",
                                  VESPER_PHASE_OBSERVE,
                                  0,
                                  0,
                                  0,
                                  nullptr,
                                  nullptr,
                                  0,
                                  0,
                                  Create,
                                  Bind,
                                  Advance,
                                  Destroy,
                                  nullptr,
                                  nullptr,
                                  nullptr,
                                  0,
                                  0};
constexpr vesper_law_library kLibrary = {
    sizeof kLibrary, VESPER_ABI_VERSION, "throwing", 1, 0, &kLaw, nullptr, nullptr, 0, 0, nullptr,
    nullptr};

}  // namespace

const vesper_law_library* vesper_law_library_entry() { return &kLibrary; }
