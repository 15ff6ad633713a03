// SPDX-License-Identifier: Apache-2.0
#include "config.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cstring>

#include "failure.hpp"
#include "versioned_struct.hpp"

namespace vesper {
namespace {

constexpr uint32_t kMaxThreads = 256;
constexpr uint32_t kDefaultProbeTimeoutMs = 5000;

std::string ProbeBesideLibrary() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&vesper_abi_version), &info) == 0) return "vesper-probe";
  const std::string library = info.dli_fname;
  const size_t slash = library.rfind('/');
  return (slash == std::string::npos ? "./" : library.substr(0, slash + 1)) + "vesper-probe";
}

}  // namespace

Config::Config(const vesper_engine_config* given) {
  if (given == nullptr) throw Failure(VESPER_INVALID_ARGUMENT, "config is null");
  const vesper_engine_config source = ReadStruct(*given, "config");
  if (source.threads == 0 || source.threads > kMaxThreads) {
    throw Failure(VESPER_INVALID_ARGUMENT, "config.threads is %u, expected 1 to %u", source.threads,
                  kMaxThreads);
  }
  if (source.validate > 1) {
    throw Failure(VESPER_INVALID_ARGUMENT, "config.validate is %u, expected 0 or 1",
                  source.validate);
  }
  if (source.deferred > 1) {
    throw Failure(VESPER_INVALID_ARGUMENT, "config.deferred is %u, expected 0 or 1",
                  source.deferred);
  }
  if (source.touches > 1) {
    throw Failure(VESPER_INVALID_ARGUMENT, "config.touches is %u, expected 0 or 1", source.touches);
  }
  if (source.limit_values > 1) {
    throw Failure(VESPER_INVALID_ARGUMENT, "config.limit_values is %u, expected 0 or 1",
                  source.limit_values);
  }
  if (source.rest_without_fields > 1) {
    throw Failure(VESPER_INVALID_ARGUMENT, "config.rest_without_fields is %u, expected 0 or 1",
                  source.rest_without_fields);
  }
  if (source.probe_timeout_ms == 0) {
    throw Failure(VESPER_INVALID_ARGUMENT, "config.probe_timeout_ms is 0, expected at least 1");
  }
  threads = source.threads;
  validate = source.validate == 1;
  deferred = source.deferred == 1;
  touches = deferred || source.touches == 1;
  probe_timeout_ms = source.probe_timeout_ms;
  law_path = source.law_path != nullptr ? source.law_path : "";
  probe_path = source.probe_path != nullptr ? source.probe_path : ProbeBesideLibrary();
  log = source.log;
  log_user = source.log_user;
  running = source.running;
  limit_values = source.limit_values == 1;
  rest_without_fields = source.rest_without_fields == 1;
}

}  // namespace vesper

void vesper_engine_config_init_sized(vesper_engine_config* config, uint64_t size) noexcept {
  if (config == nullptr) return;
  vesper_engine_config defaults{};
  defaults.struct_size = static_cast<uint32_t>(size);
  defaults.threads = 1;
  defaults.probe_timeout_ms = vesper::kDefaultProbeTimeoutMs;
  std::memset(config, 0, size);
  std::memcpy(config, &defaults, std::min<size_t>(size, sizeof defaults));
}

void(vesper_engine_config_init)(vesper_engine_config* config) noexcept {
  vesper_engine_config_init_sized(config, vesper::kFirstSize<vesper_engine_config>);
}
