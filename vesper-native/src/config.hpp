// SPDX-License-Identifier: Apache-2.0
// The engine's copy of `vesper_engine_config`.
#pragma once

#include <string>

#include "vesper/engine.h"

namespace vesper {

struct Config {
  /// Validates and copies `source`; throws INVALID_ARGUMENT.
  explicit Config(const vesper_engine_config* source);

  void Log(uint32_t level, const char* message) const {
    if (log != nullptr) log(log_user, level, message);
  }

  uint32_t threads;
  bool validate;
  bool deferred;
  bool touches;
  uint32_t probe_timeout_ms;
  std::string law_path;
  std::string probe_path;
  void (*log)(void* user, uint32_t level, const char* message);
  void* log_user;
  uint64_t* running;
  bool limit_values;
  bool rest_without_fields;
};

}  // namespace vesper
