// SPDX-License-Identifier: Apache-2.0
// Converts class templates of laws to the tables and callbacks of vesper/law.h. Part of
// vesper/law.hpp, which laws include.
#ifndef VESPER_LAW_LIBRARY_HPP_
#define VESPER_LAW_LIBRARY_HPP_

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>

#include "vesper/law.hpp"

namespace vesper::detail {

inline vesper_status Fail(vesper_error* error, const char* message) {
  if (error != nullptr) {
    *error = {};
    error->status = VESPER_LAW_FAILED;
    error->law_index = VESPER_NO_LAW;
    error->row = VESPER_NO_ROW;
    std::strncpy(error->message, message, sizeof error->message - 1);
  }
  return VESPER_LAW_FAILED;
}

/** Runs `action` and converts an exception to a status. */
template <class Action>
vesper_status Guard(vesper_error* error, Action&& action) noexcept {
  try {
    action();
    return VESPER_OK;
  } catch (const std::exception& e) {
    return Fail(error, e.what());
  } catch (...) {
    return Fail(error, "the law threw something that is no std::exception");
  }
}

/** The real type of a law: the argument of its class template. */
template <class Law>
struct RealOf;
template <template <class> class Law, class Real>
struct RealOf<Law<Real>> {
  using Type = Real;
};

template <class Law>
auto ParametersOf(Law& law) {
  if constexpr (requires { law.Parameters(); }) {
    return law.Parameters();
  } else {
    return std::tuple<>();
  }
}

/** The suite class that a law names, or void. */
template <class Law>
struct SuiteOf {
  using Type = void;
};
template <class Law>
  requires requires { typename Law::Suite; }
struct SuiteOf<Law> {
  using Type = typename Law::Suite;
};

/** True if Properties() contains an Accumulate column. */
template <class Properties>
inline constexpr bool kAccumulates = false;
template <class... Columns>
inline constexpr bool kAccumulates<std::tuple<Columns&...>> =
    ((Columns::kAccess == VESPER_ACCUMULATE) || ...);

/** True for a Deferred column that the law writes: the law writes to its own copy. */
template <class Column>
inline constexpr bool kDefersWrite = false;
template <class Row, vesper_access access, uint32_t flags>
inline constexpr bool kDefersWrite<Column<Row, access, flags>> =
    access != VESPER_READ && (flags & VESPER_USE_DEFERRED) != 0;
template <class Properties>
inline constexpr bool kDefersWrites = false;
template <class... Columns>
inline constexpr bool kDefersWrites<std::tuple<Columns&...>> = (kDefersWrite<Columns> || ...);

/** Converts a law class to the callbacks and declarations of law.h. */
template <class Law>
class Instance {
 public:
  static vesper_status Create(const vesper_host* host, [[maybe_unused]] vesper_suite* suite,
                              const double* parameters, vesper_law** out,
                              vesper_error* error) noexcept {
    return Guard(error, [&] {
      auto instance = std::make_unique<Instance>(*host);
      std::apply([&](auto&... parameter) { ((parameter.value_ = *parameters++), ...); },
                 ParametersOf(instance->law_));
      if constexpr (!std::is_void_v<typename SuiteOf<Law>::Type>) {
        instance->law_.Join(*reinterpret_cast<typename Law::Suite*>(suite));
      }
      *out = reinterpret_cast<vesper_law*>(instance.release());
    });
  }

  static vesper_status Bind(vesper_law* law, const vesper_property* properties,
                            vesper_error* error) noexcept {
    return Guard(error, [&] {
      Law& self = From(law).law_;
      const auto* at = reinterpret_cast<const char*>(properties);
      const auto next = [&]() -> const vesper_property& {
        const auto* property = reinterpret_cast<const vesper_property*>(at);
        at += properties->struct_size;
        return *property;
      };
      std::apply([&](auto&... column) { (column.Set(next()), ...); }, self.Properties());
      if constexpr (requires { self.Bind(); }) self.Bind();
    });
  }

  static vesper_status Advance(vesper_law* law, const vesper_step* step,
                               vesper_error* error) noexcept {
    return Guard(error, [&] { From(law).law_.Advance(Step(*step, From(law).host_)); });
  }

  static vesper_status PotentialEnergy(vesper_law* law, double* out, vesper_error* error) noexcept
    requires requires(Law& l) { l.PotentialEnergy(); }
  {
    return Guard(error, [&] { *out = From(law).law_.PotentialEnergy(); });
  }

  static vesper_status Synchronize(vesper_law* law, uint32_t use, vesper_error* error) noexcept {
    return Guard(error, [&] {
      Law& self = From(law).law_;
      uint32_t i = 0;  // index of the column
      std::apply([&](auto&... column) { (SynchronizeIf(i++ == use, self, column), ...); },
                 self.Properties());
    });
  }

  static void Destroy(vesper_law* law) noexcept { delete &From(law); }

  explicit Instance(const vesper_host& host) : host_(host) {}

  /** The declarations of a law in C form; part of the library's static data. */
  class Table {
   public:
    Table() {
      Law law;
      std::size_t i = 0;
      std::apply([&](auto&... column) { ((uses_[i++] = column.Use()), ...); }, law.Properties());
      i = 0;
      std::apply([&](auto&... parameter) { ((parameters_[i++] = parameter.desc_), ...); },
                 ParametersOf(law));
    }

    vesper_law_desc Desc() const {
      vesper_law_desc desc{};
      desc.struct_size = sizeof desc;
      desc.real_type = Scalar<typename RealOf<Law>::Type>::value;
      desc.name = Law::kName;
      desc.version = Law::kVersion;
      desc.doc = Law::kDoc;
      desc.phase = static_cast<vesper_phase>(Law::kPhase);
      desc.stages = Stages();
      desc.use_count = static_cast<uint32_t>(uses_.size());
      desc.parameter_count = static_cast<uint32_t>(parameters_.size());
      desc.uses = uses_.data();
      desc.parameters = parameters_.data();
      if constexpr (requires { Law::kClaims; }) desc.claims = Law::kClaims;
      desc.create = &Instance::Create;
      desc.bind = &Instance::Bind;
      desc.advance = &Instance::Advance;
      desc.destroy = &Instance::Destroy;
      if constexpr (kDefersWrites<Properties>) desc.synchronize = &Instance::Synchronize;
      if constexpr (requires(Law& law) { law.PotentialEnergy(); }) {
        desc.potential_energy = &Instance::PotentialEnergy;
      }
      if constexpr (requires { Law::kFirstStage; }) {
        static_assert(Law::kPhase == Phase::kIntegrate && Law::kFirstStage <= 1,
                      "kFirstStage is for laws of phase kIntegrate: 0 or 1");
        desc.first_stage = Law::kFirstStage;
      }
      if constexpr (requires { Law::kForceWeights; }) {
        static_assert(Law::kPhase == Phase::kIntegrate && Law::kForceWeights.size() == 1 + Stages(),
                      "kForceWeights is for laws of phase kIntegrate: 1 + kStages numbers");
        desc.force_weights = Law::kForceWeights.data();
      }
      return desc;
    }

   private:
    using Properties = decltype(std::declval<Law&>().Properties());

    static_assert(Law::kPhase == Phase::kForce || !kAccumulates<Properties>,
                  "only a law of phase kForce may have Accumulate members");

    static constexpr uint32_t Stages() {
      if constexpr (requires { Law::kStages; }) {
        static_assert(Law::kPhase == Phase::kIntegrate, "kStages is for laws of phase kIntegrate");
        return Law::kStages;
      } else {
        return Law::kPhase == Phase::kIntegrate ? 1 : 0;
      }
    }

    std::array<vesper_property_use, std::tuple_size_v<Properties>> uses_;
    std::array<vesper_parameter_desc,
               std::tuple_size_v<decltype(ParametersOf(std::declval<Law&>()))>>
        parameters_;
  };

 private:
  template <class Column>
  static void SynchronizeIf(bool wanted, Law& law, Column& column) {
    if constexpr (kDefersWrite<Column>) {
      if (wanted) law.Synchronize(column);
    }
  }
  static Instance& From(vesper_law* law) { return *reinterpret_cast<Instance*>(law); }

  Law law_;
  const vesper_host& host_;
};

/** All data to which `vesper_law_library_entry` points, for both precisions of each law. */
template <template <class> class... Laws>
class Library {
 public:
  explicit Library(const char* name, std::span<const vesper_field_desc> fields = {}) {
    library_.struct_size = sizeof library_;
    library_.abi_version = VESPER_ABI_VERSION;
    library_.name = name;
    library_.law_count = static_cast<uint32_t>(descs_.size());
    library_.laws = descs_.data();
    library_.field_count = static_cast<uint32_t>(fields.size());
    library_.fields = fields.data();
    if constexpr (!std::is_void_v<Suite>) {
      library_.open = [](const vesper_host*, vesper_suite** out, vesper_error* error) noexcept {
        return Guard(error, [&] { *out = reinterpret_cast<vesper_suite*>(new Suite()); });
      };
      library_.close = [](vesper_suite* suite) noexcept { delete reinterpret_cast<Suite*>(suite); };
    }
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  const vesper_law_library* get() const { return &library_; }

 private:
  using Suite = typename SuiteOf<std::tuple_element_t<0, std::tuple<Laws<double>...>>>::Type;
  static_assert((std::is_same_v<Suite, typename SuiteOf<Laws<float>>::Type> && ...) &&
                    (std::is_same_v<Suite, typename SuiteOf<Laws<double>>::Type> && ...),
                "the laws of a library share one Suite, the same in both precisions, or none");

  std::tuple<typename Instance<Laws<float>>::Table...> f32_;
  std::tuple<typename Instance<Laws<double>>::Table...> f64_;
  std::array<vesper_law_desc, 2 * sizeof...(Laws)> descs_ = std::apply(
      [](const auto&... table) { return std::array{table.Desc()...}; },
      std::tuple_cat(std::tie(std::get<typename Instance<Laws<float>>::Table>(f32_)...),
                     std::tie(std::get<typename Instance<Laws<double>>::Table>(f64_)...)));
  vesper_law_library library_{};
};

/** The table of a library whose laws cannot be constructed: one law, whose `create` fails with the
 *  message of the exception. Its declarations are unknown. */
class FailedLibrary {
 public:
  FailedLibrary(const char* name, const char* message) {
    Fail(&error_, message);
    law_.struct_size = sizeof law_;
    law_.name = name;
    law_.version = "0.0.0";
    law_.doc = "A law whose constructor threw an exception.";
    law_.phase = VESPER_PHASE_OBSERVE;
    law_.create = [](const vesper_host* host, vesper_suite*, const double*, vesper_law**,
                     vesper_error* error) noexcept {
      if (error != nullptr) *error = static_cast<const FailedLibrary*>(host->user)->error_;
      return vesper_status{VESPER_LAW_FAILED};
    };
    law_.bind = [](vesper_law*, const vesper_property*, vesper_error*) noexcept {
      return vesper_status{VESPER_OK};
    };
    law_.advance = [](vesper_law*, const vesper_step*, vesper_error*) noexcept {
      return vesper_status{VESPER_OK};
    };
    law_.destroy = [](vesper_law*) noexcept {};
    library_.struct_size = sizeof library_;
    library_.abi_version = VESPER_ABI_VERSION;
    library_.name = name;
    library_.law_count = 1;
    library_.laws = &law_;
    library_.user = this;
  }
  FailedLibrary(const FailedLibrary&) = delete;
  FailedLibrary& operator=(const FailedLibrary&) = delete;

  const vesper_law_library* get() const { return &library_; }

 private:
  vesper_error error_{};
  vesper_law_desc law_{};
  vesper_law_library library_{};
};

}  // namespace vesper::detail

/** Defines the library: VESPER_LAW_LIBRARY("name", Law, MoreLaws...), once, in one source file,
 *  at global scope. The library file must be libvesper_law_NAME.so with the same name. */
#define VESPER_LAW_LIBRARY(name, ...) VESPER_LAW_LIBRARY_WITH_FIELDS(name, {}, __VA_ARGS__)

/** Defines a library that provides fields, as VESPER_LAW_LIBRARY does. `fields` is an array of
 *  vesper_field_desc with static lifetime. The functions of the fields receive the Suite. */
#define VESPER_LAW_LIBRARY_WITH_FIELDS(name, fields, ...)                             \
  extern "C" VESPER_LAW_EXPORT const vesper_law_library* vesper_law_library_entry() { \
    try {                                                                             \
      static const ::vesper::detail::Library<__VA_ARGS__> library(name, fields);      \
      return library.get();                                                           \
    } catch (const std::exception& e) {                                               \
      static const ::vesper::detail::FailedLibrary failed(name, e.what());            \
      return failed.get();                                                            \
    } catch (...) {                                                                   \
      static const ::vesper::detail::FailedLibrary failed(                            \
          name, "its constructor threw something that is no std::exception");         \
      return failed.get();                                                            \
    }                                                                                 \
  }

#endif  // VESPER_LAW_LIBRARY_HPP_
