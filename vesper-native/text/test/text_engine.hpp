// SPDX-License-Identifier: Apache-2.0
// An engine that loads laws as text, for tests.
#pragma once

#include <string>
#include <vector>

#include "test_kit.hpp"
#include "vesper/engine.h"

namespace vesper::test {

/// Returns the report about a text. The report is empty if the text is valid.
inline std::string ReportOn(const std::string& text, const char* prototype = "si-f64") {
  std::vector<char> report(32768);
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_text_check(vesper_prototype_standard(prototype), "x.law", text.data(),
                             text.size(), report.data(), report.size(), error);
  }));
  return report.data();
}

/// Loads a text into an engine and returns the error.
inline vesper_error TryLoadText(TestEngine& engine, const std::string& text, vesper_library_id& id,
                                Parameters parameters = {}) {
  vesper_prepared_library* prepared = nullptr;
  const vesper_error error = Try([&](vesper_error* e) {
    return vesper_library_prepare_text("x.law", text.data(), text.size(), &prepared, e);
  });
  if (error.status != VESPER_OK) return error;
  std::vector<vesper_parameter> values;
  for (const auto& [name, value] : parameters) {
    values.push_back({sizeof(vesper_parameter), 0, name, value});
  }
  const vesper_error loaded = Try([&](vesper_error* e) {
    return vesper_engine_load_prepared(engine.get(), prepared, values.data(),
                                       static_cast<uint32_t>(values.size()), &id, e);
  });
  if (loaded.status != VESPER_OK) vesper_library_discard(prepared);
  return loaded;
}

/// Loads a text; fails the test if this fails.
inline vesper_library_id LoadText(TestEngine& engine, const std::string& text,
                                  Parameters parameters = {}) {
  vesper_library_id id = VESPER_NO_LIBRARY;
  EXPECT_OK(TryLoadText(engine, text, id, parameters));
  return id;
}

inline double PotentialEnergy(TestEngine& engine, vesper_library_id id, uint32_t law = 0) {
  double energy = 0;
  EXPECT_OK(Try([&](vesper_error* error) {
    return vesper_engine_potential_energy(engine.get(), id, law, &energy, error);
  }));
  return energy;
}

/// Returns the claims of the first law of a text.
inline uint32_t ClaimsOf(const std::string& text) {
  vesper_prepared_library* prepared = nullptr;
  const vesper_law_library* table = nullptr;
  EXPECT_OK(Try([&](vesper_error* e) {
    return vesper_library_prepare_text("x.law", text.data(), text.size(), &prepared, e);
  }));
  EXPECT_OK(Try([&](vesper_error* e) {
    return vesper_library_table(prepared, vesper_prototype_standard("si-f64"), &table, e);
  }));
  const uint32_t claims = table->laws[0].claims;
  vesper_library_discard(prepared);
  return claims;
}

inline constexpr const char* kMotion =
    "law motion \"Newton's second law.\"\n"
    "  phase integrate\n"
    "  each body:\n"
    "    if mass > 0:\n"
    "      velocity += force / mass * dt\n"
    "      position += velocity dt\n";

}  // namespace vesper::test
