// SPDX-License-Identifier: Apache-2.0
// Implementation of engine.h: each function checks pointers, catches exceptions, and calls the
// engine.
#include <algorithm>
#include <cinttypes>
#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine.hpp"
#include "failure.hpp"
#include "prototype_file.hpp"
#include "unit_parser.hpp"
#include "vesper/engine.h"

namespace {

using vesper::Config;
using vesper::Failure;
using vesper::Guarded;

template <class T>
T& Required(T* pointer, const char* name) {
  if (pointer == nullptr) throw Failure(VESPER_INVALID_ARGUMENT, "%s is null", name);
  return *pointer;
}

}  // namespace

uint32_t vesper_abi_version() noexcept { return VESPER_ABI_VERSION; }

const char* vesper_build_info() noexcept { return VESPER_BUILD_INFO; }

const char* vesper_status_name(vesper_status status) noexcept { return vesper::StatusName(status); }

vesper_status vesper_unit_parse(const char* text, vesper_unit* out, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    vesper_unit& unit = Required(out, "out");
    unit = vesper::ParseUnit(&Required(text, "text"));
  });
}

vesper_status vesper_prototype_load(const char* path, vesper_prototype** out,
                                    vesper_error* error) noexcept {
  return Guarded(error, [&] {
    vesper_prototype*& prototype = Required(out, "out");
    prototype = vesper::LoadPrototype(&Required(path, "path")).release();
  });
}

vesper_status vesper_prototype_parse(const char* text, const char* source, vesper_prototype** out,
                                     vesper_error* error) noexcept {
  return Guarded(error, [&] {
    vesper_prototype*& prototype = Required(out, "out");
    prototype =
        vesper::ParsePrototype(&Required(text, "text"), &Required(source, "source")).release();
  });
}

void vesper_prototype_free(vesper_prototype* prototype) noexcept {
  delete static_cast<vesper::OwnedPrototype*>(prototype);
}

vesper_status vesper_engine_create(const vesper_engine_config* config,
                                   const vesper_prototype* prototype, vesper_engine** out,
                                   vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(out, "out");
    *out = new vesper_engine(Config(config), Required(prototype, "prototype"));
  });
}

void vesper_engine_destroy(vesper_engine* engine) noexcept {
  if (engine == nullptr) return;
  if (engine->busy()) {
    engine->config().Log(VESPER_LOG_ERROR,
                         "vesper_engine_destroy: the engine is inside another call; not destroyed");
    return;
  }
  delete engine;
}

vesper_provider* vesper_engine_property_provider(vesper_engine* engine) noexcept {
  return engine == nullptr ? nullptr : &engine->provider();
}

vesper_status vesper_engine_set_property_provider(vesper_engine* engine,
                                                  const vesper_provider_callbacks* callbacks,
                                                  vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").SetProvider(callbacks); });
}

vesper_status vesper_provider_add_physical_property(vesper_provider* provider, const char* name,
                                                    void* data, uint64_t value_count,
                                                    const uint32_t* indices, uint64_t object_count,
                                                    vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(provider, "provider")
        .engine.AddProperty(name, {data, value_count, indices, object_count});
  });
}

vesper_status vesper_provider_rebind_physical_property(vesper_provider* provider, const char* name,
                                                       void* data, uint64_t value_count,
                                                       const uint32_t* indices,
                                                       uint64_t object_count,
                                                       vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(provider, "provider")
        .engine.RebindProperty(name, {data, value_count, indices, object_count});
  });
}

vesper_status vesper_provider_set_field(vesper_provider* provider, const char* name,
                                        const vesper_field* field, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(provider, "provider").engine.SetField(name, Required(field, "field"));
  });
}

vesper_status vesper_provider_remove_physical_property(vesper_provider* provider, const char* name,
                                                       vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(provider, "provider").engine.RemoveProperty(name); });
}

vesper_status vesper_provider_find_physical_property(const vesper_provider* provider,
                                                     const char* name, vesper_property* out,
                                                     vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(provider, "provider").engine.FindProperty(name, Required(out, "out"));
  });
}

vesper_status vesper_provider_touch(vesper_provider* provider, const char* const* names,
                                    uint32_t count, vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(provider, "provider").engine.Touch(names, count); });
}

vesper_status vesper_library_prepare(const vesper_engine_config* config, const char* library,
                                     vesper_prepared_library** out, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(out, "out");
    const Config checked(config);
    *out = new vesper_prepared_library(checked, &Required(library, "library"));
  });
}

vesper_status vesper_library_prepare_bytes(const vesper_engine_config* config, const void* bytes,
                                           uint64_t size, const char* source,
                                           vesper_prepared_library** out,
                                           vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(out, "out");
    const Config checked(config);
    const auto* first = &Required(static_cast<const std::byte*>(bytes), "bytes");
    *out = new vesper_prepared_library(checked, std::span(first, static_cast<size_t>(size)),
                                       &Required(source, "source"));
  });
}

void vesper_library_discard(vesper_prepared_library* prepared) noexcept { delete prepared; }

const char* vesper_library_name(const vesper_prepared_library* prepared) noexcept {
  return prepared == nullptr ? nullptr : prepared->name();
}

vesper_status vesper_library_prepare_text(const char* source, const char* text, uint64_t size,
                                          vesper_prepared_library** out,
                                          vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(out, "out");
    Required(text, "text");
    if (size > vesper::text::kMaxText) {
      throw Failure(VESPER_LIBRARY_LOAD_FAILED, "%s: has %" PRIu64 " bytes, a text has at most %zu",
                    source == nullptr ? "text" : source, size, vesper::text::kMaxText);
    }
    *out = new vesper_prepared_library(source == nullptr ? "text" : source,
                                       std::string(text, static_cast<size_t>(size)));
  });
}

vesper_status vesper_library_prepare_table(const vesper_law_library* table,
                                           void (*release)(void* user), void* user,
                                           vesper_prepared_library** out,
                                           vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(out, "out");
    auto prepared = std::make_unique<vesper_prepared_library>(Required(table, "table"));
    prepared->ReleaseAtEnd(release, user);
    *out = prepared.release();
  });
}

vesper_status vesper_library_table(vesper_prepared_library* prepared,
                                   const vesper_prototype* prototype,
                                   const vesper_law_library** out, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(out, "out");
    *out = &Required(prepared, "prepared")
                .TableFor(vesper::Prototype(Required(prototype, "prototype")));
  });
}

vesper_status vesper_text_check(const vesper_prototype* prototype, const char* source,
                                const char* text, uint64_t size, char* report, uint64_t capacity,
                                vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(text, "text");
    char* out = &Required(report, "report");
    if (capacity == 0) throw Failure(VESPER_INVALID_ARGUMENT, "capacity is 0, expected 1 or more");
    const std::string problems = vesper::text::Report(
        source == nullptr ? "text" : source, std::string_view(text, static_cast<size_t>(size)),
        vesper::Prototype(Required(prototype, "prototype")));
    const size_t length = std::min<size_t>(problems.size(), capacity - 1);
    std::memcpy(out, problems.data(), length);
    out[length] = '\0';
  });
}

vesper_status vesper_text_to_cpp(const vesper_prototype* prototype, const char* source,
                                 const char* text, uint64_t size, char* cpp, uint64_t capacity,
                                 uint64_t* length, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(text, "text");
    char* out = &Required(cpp, "cpp");
    uint64_t& written = Required(length, "length");
    const std::string found = vesper::text::ToCpp(
        source == nullptr ? "text" : source, std::string_view(text, static_cast<size_t>(size)),
        vesper::Prototype(Required(prototype, "prototype")));
    written = found.size();
    if (found.size() >= capacity) {
      throw Failure(VESPER_INVALID_ARGUMENT, "capacity is %llu, expected %zu or more",
                    static_cast<unsigned long long>(capacity), found.size() + 1);
    }
    std::memcpy(out, found.c_str(), found.size() + 1);
  });
}

vesper_status vesper_engine_load_prepared(vesper_engine* engine, vesper_prepared_library* prepared,
                                          const vesper_parameter* parameters, uint32_t count,
                                          vesper_library_id* out, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    vesper_library_id& id = Required(out, "out");
    id = Required(engine, "engine").Load(Required(prepared, "prepared"), parameters, count);
  });
}

vesper_status vesper_engine_load_physics_law(vesper_engine* engine, const char* library,
                                             const vesper_parameter* parameters, uint32_t count,
                                             vesper_library_id* out, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    vesper_library_id& id = Required(out, "out");
    vesper_engine& target = Required(engine, "engine");
    auto prepared =
        std::make_unique<vesper_prepared_library>(target.config(), &Required(library, "library"));
    id = target.Load(*prepared, parameters, count);
    prepared.release();
  });
}

vesper_status vesper_engine_unload_physics_law(vesper_engine* engine, vesper_library_id library,
                                               vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").Unload(library); });
}

vesper_status vesper_engine_replace_library(vesper_engine* engine, vesper_library_id library,
                                            vesper_prepared_library* prepared,
                                            const vesper_parameter* parameters, uint32_t count,
                                            vesper_error* error) noexcept {
  return Guarded(error, [&] {
    Required(engine, "engine").Replace(library, Required(prepared, "prepared"), parameters, count);
  });
}

vesper_status vesper_engine_begin_changes(vesper_engine* engine, vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").BeginChanges(); });
}

vesper_status vesper_engine_end_changes(vesper_engine* engine, uint32_t keep,
                                        vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").EndChanges(keep != 0); });
}

vesper_status vesper_engine_set_interval(vesper_engine* engine, vesper_library_id library,
                                         uint32_t interval, vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").SetInterval(library, interval); });
}

vesper_status vesper_engine_law_info(const vesper_engine* engine, vesper_library_id library,
                                     uint32_t index, vesper_law_info* out,
                                     vesper_error* error) noexcept {
  return Guarded(error,
                 [&] { Required(engine, "engine").LawInfo(library, index, Required(out, "out")); });
}

vesper_status vesper_engine_scratch_row(const vesper_engine* engine, vesper_library_id library,
                                        uint32_t law, uint32_t use, uint64_t row, double* out,
                                        uint32_t count, vesper_error* error) noexcept {
  return Guarded(error, [&] {
    double& first = Required(out, "out");
    Required(engine, "engine").ScratchRow(library, law, use, row, std::span(&first, count));
  });
}

vesper_status vesper_engine_advance(vesper_engine* engine, double dt, uint32_t steps,
                                    vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").Advance(dt, steps); });
}

vesper_status vesper_engine_synchronize(vesper_engine* engine, const char* const* names,
                                        uint32_t count, vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").Synchronize(names, count); });
}

vesper_status vesper_engine_clear_fault(vesper_engine* engine, vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").ClearFault(); });
}

vesper_status vesper_engine_move_row(vesper_engine* engine, const char* kind, uint64_t from,
                                     uint64_t to, vesper_error* error) noexcept {
  return Guarded(error,
                 [&] { Required(engine, "engine").MoveRow(&Required(kind, "kind"), from, to); });
}

vesper_status vesper_engine_state_size(vesper_engine* engine, uint64_t* out,
                                       vesper_error* error) noexcept {
  return Guarded(error, [&] {
    uint64_t& size = Required(out, "out");
    size = Required(engine, "engine").SaveState().size();
  });
}

vesper_status vesper_engine_save_state(vesper_engine* engine, void* out, uint64_t size,
                                       vesper_error* error) noexcept {
  return Guarded(error, [&] {
    const std::vector<std::byte> state = Required(engine, "engine").SaveState();
    if (size != state.size()) {
      throw Failure(VESPER_INVALID_ARGUMENT,
                    "size is %" PRIu64 ", but the state takes %zu bytes; ask state_size again",
                    size, state.size());
    }
    std::memcpy(&Required(static_cast<std::byte*>(out), "out"), state.data(), state.size());
  });
}

vesper_status vesper_engine_load_state(vesper_engine* engine, const void* state, uint64_t size,
                                       vesper_error* error) noexcept {
  return Guarded(error, [&] {
    const auto* bytes = &Required(static_cast<const std::byte*>(state), "state");
    Required(engine, "engine").LoadState({bytes, size});
  });
}

vesper_status vesper_saved_state_remove_library(void* state, uint64_t* size, const char* library,
                                                vesper_error* error) noexcept {
  return Guarded(error, [&] {
    auto* bytes = &Required(static_cast<std::byte*>(state), "state");
    uint64_t& length = Required(size, "size");
    const auto rest = vesper::WithoutLibrary({bytes, length}, &Required(library, "library"));
    std::memcpy(bytes, rest.data(), rest.size());
    length = rest.size();
  });
}

vesper_status vesper_engine_set_step_count(vesper_engine* engine, uint64_t steps, double dt,
                                           vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").SetStepCount(steps, dt); });
}

uint64_t vesper_engine_step_count(const vesper_engine* engine) noexcept {
  return engine == nullptr ? 0 : engine->step_count();
}

vesper_status vesper_engine_state_hash(vesper_engine* engine, uint64_t* out,
                                       vesper_error* error) noexcept {
  return Guarded(error, [&] {
    uint64_t& hash = Required(out, "out");
    hash = Required(engine, "engine").StateHash();
  });
}

vesper_status vesper_engine_set_ledger(vesper_engine* engine, uint32_t on,
                                       vesper_error* error) noexcept {
  return Guarded(error, [&] { Required(engine, "engine").SetLedger(on != 0); });
}

vesper_status vesper_engine_ledger(vesper_engine* engine, vesper_library_id library, uint32_t line,
                                   vesper_ledger_entry* out, vesper_error* error) noexcept {
  return Guarded(
      error, [&] { Required(engine, "engine").LedgerEntry(library, line, Required(out, "out")); });
}

vesper_status vesper_engine_potential_energy(vesper_engine* engine, vesper_library_id library,
                                             uint32_t law, double* out,
                                             vesper_error* error) noexcept {
  return Guarded(error, [&] {
    double& energy = Required(out, "out");
    energy = Required(engine, "engine").PotentialEnergy(library, law);
  });
}
