// SPDX-License-Identifier: Apache-2.0
// Loads the law from the given file; exit code 0 if the law has an effect.
#include <cstdio>

#include "vesper/engine.h"

int main(int, char** argv) {
  vesper_engine_config config;
  vesper_engine_config_init(&config);
  vesper_engine* engine = nullptr;
  vesper_error error{};
  double acceleration[3] = {};
  vesper_library_id id = 0;
  vesper_status status =
      vesper_engine_create(&config, vesper_prototype_standard("si-f64"), &engine, &error);
  if (status == VESPER_OK) {
    status =
        vesper_provider_add_physical_property(vesper_engine_property_provider(engine),
                                              "acceleration", acceleration, 1, nullptr, 1, &error);
  }
  if (status == VESPER_OK) {
    status = vesper_engine_load_physics_law(engine, argv[1], nullptr, 0, &id, &error);
  }
  if (status == VESPER_OK) status = vesper_engine_advance(engine, 1, 1, &error);
  vesper_engine_destroy(engine);
  std::printf("%s: acceleration %g %s\n", vesper_status_name(status), acceleration[2],
              error.message);
  return status == VESPER_OK && acceleration[2] == 2 ? 0 : 1;
}
