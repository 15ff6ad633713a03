// SPDX-License-Identifier: Apache-2.0
/* The C++20 layer for clients of the Vesper physics engine: header-only over engine.h.
 *
 *     vesper::PhysicsEngine engine("si-f64", {.law_path = "laws"});
 *     engine.PropertyProvider().AddPhysicalProperty("mass", masses);
 *     engine.PropertyProvider().AddPhysicalProperty("position", positions);  // 3 values a row
 *     ...
 *     engine.LoadPhysicsLaw("newton_motion");
 *     engine.Advance(1.0 / 240, 4);
 *
 * A failed call throws vesper::Error. The engine borrows arrays. The client must keep an array
 * valid and in place until it removes or rebinds the property or destroys the engine. Threads: one
 * call at a time, from any thread.
 */
#ifndef VESPER_VESPER_HPP_
#define VESPER_VESPER_HPP_

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <ranges>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "vesper/engine.h"

namespace vesper {

/** A failed call. what() contains the name of the object, what was found and what was expected. */
class Error : public std::runtime_error {
 public:
  /** Copies the error of a call; `law` is the name of the law that caused it. */
  explicit Error(const vesper_error& error, std::string law = {})
      : std::runtime_error(std::string(vesper_status_name(error.status)) + ": " + error.message),
        error_(error),
        law_(std::move(law)) {}

  /** Returns the status of the call; never VESPER_OK. */
  vesper_status status() const { return error_.status; }
  /** Returns the library that caused the failure, or VESPER_NO_LIBRARY. */
  vesper_library_id library() const { return error_.library_id; }
  /** Returns the name of the loaded law that caused the failure; empty if no law did. */
  const std::string& law() const { return law_; }
  /** Returns the property involved; empty if none is. */
  std::string_view property() const { return error_.property; }
  /** Returns the row of the property, or VESPER_NO_ROW. */
  uint64_t row() const { return error_.row; }
  /** Returns the stage in which the step failed, or 0 if the error did not occur during a step. */
  uint32_t stage() const { return error_.stage; }

 private:
  vesper_error error_;
  std::string law_;
};

namespace detail {

inline void Check(vesper_status status, const vesper_error& error) {
  if (status != VESPER_OK) throw Error(error);
}

[[noreturn]] inline void Throw(vesper_status status, const std::string& property,
                               const std::string& message) {
  vesper_error error{};
  error.status = status;
  error.law_index = VESPER_NO_LAW;
  error.row = VESPER_NO_ROW;
  property.copy(error.property, sizeof error.property - 1);
  message.copy(error.message, sizeof error.message - 1);
  throw Error(error);
}

/** Scalar type of a property, and its number of values per row. */
struct Shape {
  vesper_scalar_type scalar_type;
  uint32_t components;
};
using Shapes = std::map<std::string, Shape, std::less<>>;

inline Shapes ShapesOf(const vesper_prototype& prototype) {
  Shapes shapes;
  const auto* at = reinterpret_cast<const char*>(prototype.properties);
  for (uint32_t i = 0; i < prototype.property_count; ++i) {
    const auto& property = *reinterpret_cast<const vesper_property_descriptor*>(at);
    if (property.name != nullptr) {
      shapes[property.name] = {property.scalar_type, property.components};
    }
    at += prototype.properties->struct_size;
  }
  return shapes;
}

template <class Value>
constexpr vesper_scalar_type ScalarTypeOf() {
  using T = std::remove_cv_t<Value>;
  if constexpr (std::is_same_v<T, float>) return VESPER_F32;
  if constexpr (std::is_same_v<T, double>) return VESPER_F64;
  if constexpr (std::is_same_v<T, int32_t>) return VESPER_I32;
  if constexpr (std::is_same_v<T, uint32_t>) return VESPER_U32;
  return 0;
}

inline const char* NameOf(vesper_scalar_type type) {
  constexpr const char* kNames[] = {"another type", "f32", "f64", "i32", "u32"};
  return type < std::size(kNames) ? kNames[type] : kNames[0];
}

/** A flat array of values that outlives the call: an lvalue container or a span. */
template <class Range>
concept Values =
    std::ranges::contiguous_range<Range> && std::ranges::sized_range<Range> &&
    std::ranges::borrowed_range<Range> && ScalarTypeOf<std::ranges::range_value_t<Range>>() != 0 &&
    !std::is_const_v<std::remove_reference_t<std::ranges::range_reference_t<Range>>>;

}  // namespace detail

/** Returns "si-f64" or "si-f32"; static. Throws NOT_FOUND for any other name. */
inline const vesper_prototype& StandardPrototype(const std::string& name) {
  const vesper_prototype* prototype = vesper_prototype_standard(name.c_str());
  if (prototype == nullptr) {
    detail::Throw(VESPER_NOT_FOUND, "",
                  "no standard prototype '" + name + "'; there are si-f64 and si-f32");
  }
  return *prototype;
}

/** Parses a unit, e.g. "km/h"; see vesper_unit_parse. */
inline vesper_unit ParseUnit(const std::string& text) {
  vesper_unit unit{};
  vesper_error error{};
  detail::Check(vesper_unit_parse(text.c_str(), &unit, &error), error);
  return unit;
}

/** A prototype read from a file or from text. Move-only. */
class LoadedPrototype {
 public:
  /** Reads a prototype from a file; see vesper_prototype_load. */
  explicit LoadedPrototype(const std::string& path) {
    vesper_prototype* prototype = nullptr;
    vesper_error error{};
    detail::Check(vesper_prototype_load(path.c_str(), &prototype, &error), error);
    prototype_.reset(prototype);
  }
  /** Parses a prototype; `source` names the text in messages. */
  LoadedPrototype(const std::string& text, const std::string& source) {
    vesper_prototype* prototype = nullptr;
    vesper_error error{};
    detail::Check(vesper_prototype_parse(text.c_str(), source.c_str(), &prototype, &error), error);
    prototype_.reset(prototype);
  }

  /** Returns the prototype; valid as long as this object lives. */
  const vesper_prototype& get() const { return *prototype_; }

 private:
  struct Free {
    void operator()(vesper_prototype* prototype) const { vesper_prototype_free(prototype); }
  };
  std::unique_ptr<vesper_prototype, Free> prototype_;
};

/** Configuration of an engine; fields that are not set have the engine's defaults. */
struct EngineConfig {
  /** Number of threads for concurrent laws and for parallel_for, including the caller's thread. */
  uint32_t threads = 1;
  /** If true, laws run on guarded copies, and the engine checks them against their declarations. */
  bool validate = false;
  /** Folders in which bare law names are searched, separated by ':'. */
  std::string law_path = {};
  /** Path of the `vesper-probe` program; empty: beside the engine library. */
  std::string probe_path = {};
  /** If true, deferred writes reach the arrays only at Synchronize; see vesper_engine_config. */
  bool deferred = false;
  /** If true, the client calls Touch for every array that it edited. Laws may then keep data that
   *  they derived from other arrays. */
  bool touches = false;
  /** If true, a law rests while a field that it reads is not bound; see vesper_engine_config. */
  bool rest_without_fields = false;
  /** Receives log lines (VESPER_LOG_..., text) on the calling thread. Must not throw. */
  std::function<void(uint32_t, const char*)> log = {};

  /** Returns the configuration as the C struct; it points into this object. */
  vesper_engine_config View() const {
    vesper_engine_config config;
    vesper_engine_config_init(&config);
    config.threads = threads;
    config.validate = validate ? 1 : 0;
    config.deferred = deferred ? 1 : 0;
    config.touches = touches ? 1 : 0;
    config.rest_without_fields = rest_without_fields ? 1 : 0;
    config.law_path = law_path.c_str();
    if (!probe_path.empty()) config.probe_path = probe_path.c_str();
    if (log) {
      config.log = [](void* user, uint32_t level, const char* message) {
        static_cast<const EngineConfig*>(user)->log(level, message);
      };
      config.log_user = const_cast<EngineConfig*>(this);
    }
    return config;
  }
};

/** A value for a parameter of a law, in the unit that the law declares for it. `name` is
 *  `parameter`, or `law.parameter` in a library of several laws. */
struct ParameterValue {
  std::string name; /**< `parameter`, or `law.parameter`. */
  double value;     /**< Value in the unit that the law declares. */
};

/** Registers the client's arrays with an engine. A borrowed handle, valid as long as its engine. */
class PhysicalPropertyProvider {
 public:
  /** Registers an array. `values` is a flat container or span, (rows x components) of the
   *  prototype's type, borrowed. With `indices` (rows), row i is value indices[i]; such shared
   *  values are read-only to laws. */
  template <detail::Values Values>
  void AddPhysicalProperty(const std::string& name, Values&& values,
                           std::span<const uint32_t> indices = {}) {
    Register(vesper_provider_add_physical_property, name, values, indices);
  }
  /** Replaces an array after it grew, shrank or moved. The arguments are those of
   *  AddPhysicalProperty. */
  template <detail::Values Values>
  void RebindPhysicalProperty(const std::string& name, Values&& values,
                              std::span<const uint32_t> indices = {}) {
    Register(vesper_provider_rebind_physical_property, name, values, indices);
  }
  /** Registers or replaces the function of a FIELD property; `field` is copied. */
  void SetField(const std::string& name, const vesper_field& field) {
    vesper_error error{};
    detail::Check(vesper_provider_set_field(provider_, name.c_str(), &field, &error), error);
  }
  /** Unbinds a property. Throws ACCESS_CONFLICT while a loaded law needs it. */
  void RemovePhysicalProperty(const std::string& name) {
    vesper_error error{};
    detail::Check(vesper_provider_remove_physical_property(provider_, name.c_str(), &error), error);
  }
  /** Returns the property as it is bound. */
  vesper_property FindPhysicalProperty(const std::string& name) const {
    vesper_property property{};
    property.struct_size = sizeof property;
    vesper_error error{};
    detail::Check(
        vesper_provider_find_physical_property(provider_, name.c_str(), &property, &error), error);
    return property;
  }
  /** Marks values of these properties as edited in place; see vesper_provider_touch. */
  void Touch(std::initializer_list<const char*> names) {
    vesper_error error{};
    detail::Check(vesper_provider_touch(provider_, names.begin(),
                                        static_cast<uint32_t>(names.size()), &error),
                  error);
  }
  /** Marks values of all properties as edited in place. */
  void Touch() {
    vesper_error error{};
    detail::Check(vesper_provider_touch(provider_, nullptr, 0, &error), error);
  }

 private:
  friend class PhysicsEngine;
  using RegisterFunction = decltype(&vesper_provider_add_physical_property);

  PhysicalPropertyProvider(vesper_provider* provider, const detail::Shapes& shapes)
      : provider_(provider), shapes_(&shapes) {}

  template <class Values>
  void Register(RegisterFunction function, const std::string& name, Values& values,
                std::span<const uint32_t> indices) {
    using Value = std::ranges::range_value_t<Values>;
    const uint64_t rows = RowsOf(name, detail::ScalarTypeOf<Value>(), std::ranges::size(values));
    vesper_error error{};
    detail::Check(function(provider_, name.c_str(), std::ranges::data(values), rows, indices.data(),
                           indices.data() ? indices.size() : rows, &error),
                  error);
  }

  uint64_t RowsOf(const std::string& name, vesper_scalar_type type, uint64_t size) const {
    const auto shape = shapes_->find(name);
    if (shape == shapes_->end()) return size;  // the engine refuses the unknown name
    const auto [expected, components] = shape->second;
    if (type != expected) {
      detail::Throw(VESPER_TYPE_MISMATCH, name,
                    "property '" + name + "': array of " + detail::NameOf(type) + ", expected " +
                        detail::NameOf(expected));
    }
    if (size % components != 0) {
      detail::Throw(VESPER_COUNT_MISMATCH, name,
                    "property '" + name + "': array of " + std::to_string(size) +
                        " values, expected a multiple of its " + std::to_string(components) +
                        " components");
    }
    return size / components;
  }

  vesper_provider* provider_;
  const detail::Shapes* shapes_;
};

/** Base class of a property provider that the client implements. The engine queries it for
 *  arrays between steps. It must not call the engine. */
class CustomPropertyProvider {
 public:
  virtual ~CustomPropertyProvider() = default;
  /** Returns the arrays of a property (struct_size may stay 0), or nothing if the client has no
   *  such property. If this function throws an exception, the engine call that needed the property
   *  fails. */
  virtual std::optional<vesper_provided_property> FindPhysicalProperty(std::string_view name) = 0;
  /** Returns a number that changes whenever the answer of FindPhysicalProperty changes for any
   *  property. */
  virtual uint64_t Version() const noexcept = 0;

 private:
  friend class PhysicsEngine;

  static vesper_status Find(void* user, const char* name, vesper_provided_property* out,
                            vesper_error* error) {
    try {
      const auto found = static_cast<CustomPropertyProvider*>(user)->FindPhysicalProperty(name);
      if (!found) return VESPER_NOT_FOUND;
      const uint32_t struct_size = out->struct_size;
      *out = *found;
      out->struct_size = struct_size;
      return VESPER_OK;
    } catch (const std::exception& exception) {
      const std::string_view message = exception.what();
      message.copy(error->message, sizeof error->message - 1);
      return VESPER_INVALID_ARGUMENT;
    }
  }
  static uint64_t AskVersion(void* user) {
    return static_cast<const CustomPropertyProvider*>(user)->Version();
  }
};

/** A law library that was opened and checked, on any thread, but not yet loaded into an engine. */
class PreparedLibrary {
 public:
  /** Prepares `library`: a bare name to search in `config.law_path`, or a path with a '/'. */
  PreparedLibrary(const EngineConfig& config, const std::string& library) {
    const vesper_engine_config view = config.View();
    vesper_prepared_library* prepared = nullptr;
    vesper_error error{};
    detail::Check(vesper_library_prepare(&view, library.c_str(), &prepared, &error), error);
    prepared_.reset(prepared);
  }

  /** Takes over a library that a function of engine.h has prepared. */
  explicit PreparedLibrary(vesper_prepared_library* prepared) : prepared_(prepared) {}

  /** Returns the name in the library's own table. */
  std::string name() const { return vesper_library_name(prepared_.get()); }

 private:
  friend class PhysicsEngine;
  struct Discard {
    void operator()(vesper_prepared_library* prepared) const { vesper_library_discard(prepared); }
  };
  std::unique_ptr<vesper_prepared_library, Discard> prepared_;
};

/** Applies laws to named arrays that belong to the client. Move-only. */
class PhysicsEngine {
 public:
  /** Creates an engine with a standard prototype, given by name. */
  explicit PhysicsEngine(const std::string& prototype, EngineConfig config = {})
      : PhysicsEngine(StandardPrototype(prototype), std::move(config)) {}

  /** Creates an engine with any prototype, which is copied. */
  explicit PhysicsEngine(const vesper_prototype& prototype, EngineConfig config = {})
      : state_(std::make_unique<State>(State{std::move(config), detail::ShapesOf(prototype)})) {
    const vesper_engine_config view = state_->config.View();
    vesper_engine* engine = nullptr;
    vesper_error error{};
    detail::Check(vesper_engine_create(&view, &prototype, &engine, &error), error);
    engine_.reset(engine);
  }

  /** Returns the provider of this engine, which registers arrays; valid as long as the engine. */
  PhysicalPropertyProvider PropertyProvider() {
    return {vesper_engine_property_provider(engine_.get()), state_->shapes};
  }

  /** Makes the engine query `provider` for arrays, instead of using registered ones; see
   *  vesper_engine_set_property_provider. `provider` must live until the engine is destroyed or
   *  another provider is set. Null: arrays must be registered again. */
  void SetPropertyProvider(CustomPropertyProvider* provider) {
    const vesper_provider_callbacks callbacks{sizeof callbacks, 0, provider,
                                              CustomPropertyProvider::Find,
                                              CustomPropertyProvider::AskVersion};
    vesper_error error{};
    detail::Check(vesper_engine_set_property_provider(
                      engine_.get(), provider == nullptr ? nullptr : &callbacks, &error),
                  error);
  }

  /** Loads `library`: a bare name to search in the law path, or a path with a '/'. */
  vesper_library_id LoadPhysicsLaw(const std::string& library,
                                   const std::vector<ParameterValue>& parameters = {}) {
    const auto values = View(parameters);
    vesper_library_id id = VESPER_NO_LIBRARY;
    vesper_error error{};
    detail::Check(vesper_engine_load_physics_law(engine_.get(), library.c_str(), values.data(),
                                                 static_cast<uint32_t>(values.size()), &id, &error),
                  error);
    return id;
  }
  /** Activates a prepared library without delay. If this throws, `prepared` is unchanged. */
  vesper_library_id LoadPhysicsLaw(PreparedLibrary&& prepared,
                                   const std::vector<ParameterValue>& parameters = {}) {
    const auto values = View(parameters);
    vesper_library_id id = VESPER_NO_LIBRARY;
    vesper_error error{};
    detail::Check(
        vesper_engine_load_prepared(engine_.get(), prepared.prepared_.get(), values.data(),
                                    static_cast<uint32_t>(values.size()), &id, &error),
        error);
    static_cast<void>(prepared.prepared_.release());
    return id;
  }
  /** Unloads a library's laws, between frames, without delay. */
  void UnloadPhysicsLaw(vesper_library_id library) {
    vesper_error error{};
    detail::Check(vesper_engine_unload_physics_law(engine_.get(), library, &error), error);
  }
  /** Replaces a loaded library between two frames; see `vesper_engine_replace_library`. If this
   *  throws, the old library stays and `prepared` is unchanged. */
  void ReplaceLibrary(vesper_library_id library, PreparedLibrary&& prepared,
                      const std::vector<ParameterValue>& parameters = {}) {
    const auto values = View(parameters);
    vesper_error error{};
    detail::Check(
        vesper_engine_replace_library(engine_.get(), library, prepared.prepared_.get(),
                                      values.data(), static_cast<uint32_t>(values.size()), &error),
        error);
    static_cast<void>(prepared.prepared_.release());
  }
  /** Begins changes that can be undone as a whole; see `vesper_engine_begin_changes`. */
  void BeginChanges() {
    vesper_error error{};
    detail::Check(vesper_engine_begin_changes(engine_.get(), &error), error);
  }
  /** Keeps the changes since BeginChanges, or undoes them; see `vesper_engine_end_changes`. */
  void EndChanges(bool keep) {
    vesper_error error{};
    detail::Check(vesper_engine_end_changes(engine_.get(), keep ? 1 : 0, &error), error);
  }
  /** Sets in which steps the laws of a library are called; see `vesper_engine_set_interval`. */
  void SetInterval(vesper_library_id library, uint32_t interval) {
    vesper_error error{};
    detail::Check(vesper_engine_set_interval(engine_.get(), library, interval, &error), error);
  }
  /** Returns the SCRATCH values of one row of a law, as doubles; see `vesper_engine_scratch_row`.
   *  `components` is that of the use. */
  std::vector<double> ScratchRow(vesper_library_id library, uint32_t law, uint32_t use,
                                 uint32_t components, uint64_t row) const {
    std::vector<double> values(components);
    vesper_error error{};
    detail::Check(vesper_engine_scratch_row(engine_.get(), library, law, use, row, values.data(),
                                            components, &error),
                  error);
    return values;
  }
  /** Returns the laws of a loaded library, in the engine's precision; valid until the library is
   *  unloaded. */
  std::vector<vesper_law_info> Laws(vesper_library_id library) const {
    std::vector<vesper_law_info> laws;
    vesper_error error{};
    for (uint32_t i = 0;; ++i) {
      vesper_law_info info{};
      info.struct_size = sizeof info;
      const vesper_status status = vesper_engine_law_info(engine_.get(), library, i, &info, &error);
      if (status == VESPER_NOT_FOUND && i > 0) return laws;
      detail::Check(status, error);
      laws.push_back(info);
    }
  }

  /** Applies all laws for `steps` steps of `dt` [time unit of the prototype]. Either all steps
   *  count, or none. If this throws, the written arrays are undefined: restore them, then call
   *  ClearFault or unload Error::library(). */
  void Advance(double dt, uint32_t steps = 1) {
    vesper_error error{};
    const vesper_status status = vesper_engine_advance(engine_.get(), dt, steps, &error);
    if (status != VESPER_OK) throw Error(error, LawName(error));
  }
  /** Writes deferred values to these arrays. Call it before the client reads or edits them, if
   *  EngineConfig::deferred is set. See vesper_engine_synchronize. */
  void Synchronize(std::span<const char* const> names) {
    vesper_error error{};
    const vesper_status status = vesper_engine_synchronize(
        engine_.get(), names.data(), static_cast<uint32_t>(names.size()), &error);
    if (status != VESPER_OK) throw Error(error, LawName(error));
  }
  /** Writes deferred values to these arrays. */
  void Synchronize(std::initializer_list<const char*> names) {
    Synchronize(std::span(names.begin(), names.size()));
  }
  /** Writes deferred values to all arrays. */
  void Synchronize() {
    vesper_error error{};
    const vesper_status status = vesper_engine_synchronize(engine_.get(), nullptr, 0, &error);
    if (status != VESPER_OK) throw Error(error, LawName(error));
  }
  /** Clears the fault of a failed step. The client must have restored the arrays. */
  void ClearFault() {
    vesper_error error{};
    detail::Check(vesper_engine_clear_fault(engine_.get(), &error), error);
  }
  /** Announces that row `from` of the kind moves to row `to`, whose item was removed; see
   *  vesper_engine_move_row. */
  void MoveRow(const std::string& kind, uint64_t from, uint64_t to) {
    vesper_error error{};
    detail::Check(vesper_engine_move_row(engine_.get(), kind.c_str(), from, to, &error), error);
  }
  /** Returns step count, time and the SCRATCH values of laws, from which a run can continue; see
   *  vesper_engine_save_state. */
  std::vector<std::byte> SaveState() {
    uint64_t size = 0;
    vesper_error error{};
    detail::Check(vesper_engine_state_size(engine_.get(), &size, &error), error);
    std::vector<std::byte> state(size);
    detail::Check(vesper_engine_save_state(engine_.get(), state.data(), size, &error), error);
    return state;
  }
  /** Restores a state returned by SaveState; see vesper_engine_load_state. */
  void LoadState(const std::vector<std::byte>& state) {
    vesper_error error{};
    detail::Check(vesper_engine_load_state(engine_.get(), state.data(), state.size(), &error),
                  error);
  }
  /** Switches the ledger on or off, and resets it. It records the momentum and energy that each law
   *  gives to the bodies. See vesper_engine_set_ledger. */
  void SetLedger(bool on) {
    vesper_error error{};
    detail::Check(vesper_engine_set_ledger(engine_.get(), on ? 1 : 0, &error), error);
  }
  /** Returns the ledger line of a law. For VESPER_NO_LIBRARY, `line` is VESPER_LEDGER_CLIENT,
   *  GROUND, UNLOADED or TOTAL; see vesper_engine_ledger. */
  vesper_ledger_entry Ledger(vesper_library_id library, uint32_t line = 0) {
    vesper_ledger_entry entry{};
    entry.struct_size = sizeof entry;
    vesper_error error{};
    detail::Check(vesper_engine_ledger(engine_.get(), library, line, &entry, &error), error);
    return entry;
  }
  /** Returns the potential energy [J] in the present state; throws NOT_FOUND if the law reports
   *  none. */
  double PotentialEnergy(vesper_library_id library, uint32_t law = 0) {
    double energy = 0;
    vesper_error error{};
    detail::Check(vesper_engine_potential_energy(engine_.get(), library, law, &energy, &error),
                  error);
    return energy;
  }
  /** Sets step count and time as if `steps` steps of `dt` [s] had been made; see
   *  vesper_engine_set_step_count. */
  void SetStepCount(uint64_t steps, double dt) {
    vesper_error error{};
    detail::Check(vesper_engine_set_step_count(engine_.get(), steps, dt, &error), error);
  }
  /** Returns the number of steps since creation, including those from SetStepCount or LoadState. */
  uint64_t StepCount() const { return vesper_engine_step_count(engine_.get()); }
  /** Returns the hash of the state; equal states have equal hashes. See
   *  vesper_engine_state_hash. */
  uint64_t StateHash() {
    uint64_t hash = 0;
    vesper_error error{};
    detail::Check(vesper_engine_state_hash(engine_.get(), &hash, &error), error);
    return hash;
  }

 private:
  /** Data to which the engine or its provider points; it keeps its address when the PhysicsEngine
   *  object is moved. */
  struct State {
    EngineConfig config;
    detail::Shapes shapes;
  };
  struct Destroy {
    void operator()(vesper_engine* engine) const { vesper_engine_destroy(engine); }
  };

  static std::vector<vesper_parameter> View(const std::vector<ParameterValue>& parameters) {
    std::vector<vesper_parameter> view;
    for (const ParameterValue& parameter : parameters) {
      view.push_back({sizeof(vesper_parameter), 0, parameter.name.c_str(), parameter.value});
    }
    return view;
  }

  std::string LawName(const vesper_error& blame) const {
    vesper_law_info info{};
    info.struct_size = sizeof info;
    const vesper_status status =
        vesper_engine_law_info(engine_.get(), blame.library_id, blame.law_index, &info, nullptr);
    return status == VESPER_OK ? info.name : "";
  }

  std::unique_ptr<State> state_;
  std::unique_ptr<vesper_engine, Destroy> engine_;
};

}  // namespace vesper

#endif  // VESPER_VESPER_HPP_
