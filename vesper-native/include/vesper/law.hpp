/* The C++20 layer for authors of physics laws; a law library needs nothing else.
 *
 * A law is a class template over the real type. Its members are the properties and parameters it
 * uses, and one macro at the end of the file makes the library, for both precisions:
 *
 *     using namespace vesper;
 *
 *     template <class Real>
 *     struct UniformWeight {
 *       static constexpr auto kName = "uniform_weight", kVersion = "1.0.0";
 *       static constexpr auto kDoc = "Pulls every body down with its mass times g.";
 *       static constexpr auto kPhase = Phase::kForce;
 *
 *       Parameter g{"g", "Free fall.", units::metre_per_second_squared, 9.81, 0.0, 100.0};
 *       Read<Real> mass{"mass", "body", units::kilogram};
 *       Accumulate<Vec3<Real>> force{"externalForce", "body", units::newton};
 *
 *       auto Parameters() { return std::tie(g); }
 *       auto Properties() { return std::tie(mass, force); }
 *
 *       void Advance(const Step&) {
 *         for (uint64_t i = 0; i < mass.size(); ++i) force[i].y -= mass[i] * Real(g);
 *       }
 *     };
 *     VESPER_LAW_LIBRARY("uniform_weight", UniformWeight)
 *
 * Members that a law must have: kName, kVersion, kDoc, kPhase, Properties(), Advance(). It may have:
 *   uint32_t kStages        force evaluations per step of an integrator; 1 if absent
 *   uint32_t kFirstStage    1 if an integrator has nothing to do before the first of them (stage 0)
 *   std::array<double, 1 + kStages> kForceWeights
 *                           how its velocities follow from the forces; see `force_weights` in law.h
 *   uint32_t kClaims        vesper::Claim values joined with |; none if absent
 *   auto Parameters()       std::tie of its parameters
 *   void Bind()             rebuilds what it caches: arrays are new, or were edited by the client
 *   double PotentialEnergy()  [J] of the present state
 *   void Synchronize(auto& column)  writes a Deferred column of its own; needed if it has one
 *   using Suite = S;        a class that the laws of the library share: one S for each engine, made
 *   void Join(Suite&)       with S() before its laws and dropped after them; handed to each law once
 *                           it has its parameters, in the order of the library
 *
 * The law is default-constructed once when its library is opened, to read the declarations, and
 * once for every engine that loads it. Names and docs must be string literals. An exception thrown
 * by the constructor or by Join at load, by Bind, Advance or PotentialEnergy becomes LAW_FAILED with its
 * what() as message.
 */
#ifndef VESPER_LAW_HPP_
#define VESPER_LAW_HPP_

#ifdef __FAST_MATH__
#error "laws are built without -ffast-math: it drops NaN and gives other bits on every machine"
#endif

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <tuple>
#include <type_traits>
#include <utility>

#include "vesper/law.h"

namespace vesper {

/** When a law runs within a step: phase by phase, and in order of loading within one. */
enum class Phase : vesper_phase {
  kForce = VESPER_PHASE_FORCE,
  kIntegrate = VESPER_PHASE_INTEGRATE,
  kConstrain = VESPER_PHASE_CONSTRAIN,
  kObserve = VESPER_PHASE_OBSERVE,
};

/** What a law promises; the law contract tests hold it to it. */
enum Claim : uint32_t {
  kMomentum = VESPER_CLAIM_MOMENTUM,
  kAngularMomentum = VESPER_CLAIM_ANGULAR_MOMENTUM,
  kTranslation = VESPER_CLAIM_TRANSLATION,
  kRotation = VESPER_CLAIM_ROTATION,
};

namespace units {
inline constexpr vesper_unit one = VESPER_UNIT_ONE;
inline constexpr vesper_unit metre = VESPER_UNIT_METRE;
inline constexpr vesper_unit kilogram = VESPER_UNIT_KILOGRAM;
inline constexpr vesper_unit second = VESPER_UNIT_SECOND;
inline constexpr vesper_unit kelvin = VESPER_UNIT_KELVIN;
inline constexpr vesper_unit coulomb = VESPER_UNIT_COULOMB;
inline constexpr vesper_unit metre_per_second = VESPER_UNIT_METRE_PER_SECOND;
inline constexpr vesper_unit metre_per_second_squared = VESPER_UNIT_METRE_PER_SECOND_SQUARED;
inline constexpr vesper_unit radian_per_second = VESPER_UNIT_RADIAN_PER_SECOND;
inline constexpr vesper_unit newton = VESPER_UNIT_NEWTON;
inline constexpr vesper_unit newton_metre = VESPER_UNIT_NEWTON_METRE;
inline constexpr vesper_unit newton_per_metre = VESPER_UNIT_NEWTON_PER_METRE;
inline constexpr vesper_unit newton_second_per_metre = VESPER_UNIT_NEWTON_SECOND_PER_METRE;
inline constexpr vesper_unit kilogram_metre_squared = VESPER_UNIT_KILOGRAM_METRE_SQUARED;
inline constexpr vesper_unit kilogram_per_metre = VESPER_UNIT_KILOGRAM_PER_METRE;
inline constexpr vesper_unit kilogram_per_second = VESPER_UNIT_KILOGRAM_PER_SECOND;
inline constexpr vesper_unit volt_per_metre = VESPER_UNIT_VOLT_PER_METRE;
inline constexpr vesper_unit tesla = VESPER_UNIT_TESLA;
inline constexpr vesper_unit gravitational_constant = VESPER_UNIT_GRAVITATIONAL_CONSTANT;
inline constexpr vesper_unit coulomb_constant = VESPER_UNIT_COULOMB_CONSTANT;
}  // namespace units

/** Three numbers of one row, as they lie in a column of 3 components. */
template <class Real>
struct Vec3 {
  Real x{}, y{}, z{};

  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3 operator*(Vec3 a, Real s) { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3 operator*(Real s, Vec3 a) { return a * s; }
  friend constexpr Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }
  friend constexpr Vec3& operator-=(Vec3& a, Vec3 b) { return a = a - b; }
  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

template <class Real>
constexpr Real Dot(Vec3<Real> a, Vec3<Real> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
constexpr Vec3<Real> Cross(Vec3<Real> a, Vec3<Real> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
Real Length(Vec3<Real> a) {
  return std::sqrt(Dot(a, a));
}

namespace detail {

template <class T>
struct Scalar;
template <>
struct Scalar<float> : std::integral_constant<vesper_scalar_type, VESPER_F32> {};
template <>
struct Scalar<double> : std::integral_constant<vesper_scalar_type, VESPER_F64> {};
template <>
struct Scalar<int32_t> : std::integral_constant<vesper_scalar_type, VESPER_I32> {};
template <>
struct Scalar<uint32_t> : std::integral_constant<vesper_scalar_type, VESPER_U32> {};

/** Scalar type and number of components of what a row holds. */
template <class Row>
struct RowType {
  static constexpr vesper_scalar_type kScalar = Scalar<Row>::value;
  static constexpr uint32_t kComponents = 1;
};
template <class Real>
struct RowType<Vec3<Real>> {
  static constexpr vesper_scalar_type kScalar = Scalar<Real>::value;
  static constexpr uint32_t kComponents = 3;
};
template <class T, std::size_t n>
struct RowType<std::array<T, n>> {
  static constexpr vesper_scalar_type kScalar = Scalar<T>::value;
  static constexpr uint32_t kComponents = n;
};

template <class Law>
class Instance;

}  // namespace detail

/** A column that a law uses: (rows x components of Row), borrowed from the client between two
 *  Binds. Row is float, double, int32_t, uint32_t, Vec3 of a real, or std::array of a scalar. What
 *  the access only reads is const. Use it through the names below. */
template <class Row, vesper_access access, uint32_t flags>
class Column {
 public:
  static constexpr vesper_access kAccess = access;
  using Element = std::conditional_t<access == VESPER_READ, const Row, Row>;

  constexpr Column(const char* name, const char* kind, const vesper_unit& unit)
      : name_(name), kind_(kind), unit_(unit) {}

  Element& operator[](uint64_t row) const { return data_[row]; }
  Element* data() const { return data_; }
  Element* begin() const { return data_; }
  Element* end() const { return data_ + size_; }
  /** Rows; 0 if an optional property is absent. */
  uint64_t size() const { return size_; }
  const char* name() const { return name_; }
  /** Another number once the client has touched or rebound the property; of a Deferred column, whenever
   *  anybody else wrote the array. */
  uint64_t version() const { return version_; }
  /** False if the prototype lacks this optional property or the client gave no array for it. */
  bool present() const requires((flags & VESPER_USE_OPTIONAL) != 0) { return data_ != nullptr; }

 private:
  template <class Law>
  friend class detail::Instance;

  constexpr vesper_property_use Use() const {
    using Type = detail::RowType<Row>;
    return {sizeof(vesper_property_use), Type::kScalar, name_, kind_, Type::kComponents, access,
            unit_, flags, 0};
  }
  void Set(const vesper_property& property) {
    data_ = static_cast<Element*>(property.data);
    size_ = property.row_count;
    version_ = property.version;
  }

  const char* name_;
  const char* kind_;
  vesper_unit unit_;
  Element* data_ = nullptr;
  uint64_t size_ = 0;
  uint64_t version_ = 0;
};

template <class Row>
using Read = Column<Row, VESPER_READ, 0>;
/** Every row must be written before Advance returns; what was in it is not to be read. */
template <class Row>
using Write = Column<Row, VESPER_WRITE, 0>;
template <class Row>
using ReadWrite = Column<Row, VESPER_READ_WRITE, 0>;
/** Add to it, in phase kForce. It starts at zero for each law; the engine sums over laws. */
template <class Row>
using Accumulate = Column<Row, VESPER_ACCUMULATE, 0>;
/** Memory that the engine keeps for this law, one Row for each row of the kind, zero at first; read
 *  and written in Advance only. It is undone with a step that failed, saved with the engine, and
 *  follows its row when the client moves that. The name is the law's own. */
template <class Row>
using Scratch = Column<Row, VESPER_SCRATCH, 0>;
template <class Row>
using OptionalRead = Column<Row, VESPER_READ, VESPER_USE_OPTIONAL>;
template <class Row>
using OptionalWrite = Column<Row, VESPER_WRITE, VESPER_USE_OPTIONAL>;
template <class Row>
using OptionalReadWrite = Column<Row, VESPER_READ_WRITE, VESPER_USE_OPTIONAL>;
template <class Row>
using OptionalAccumulate = Column<Row, VESPER_ACCUMULATE, VESPER_USE_OPTIONAL>;

/** Columns of which the laws of a library keep one copy in their Suite, on a device say. Bind takes
 *  the array if version() is another than the copy was taken at; otherwise the copy counts, and may
 *  be newer than the array. Advance works on the copy only. What it writes there, the engine asks
 *  for by law.Synchronize(column), which must fill the whole column; see VESPER_USE_DEFERRED. */
template <class Row>
using DeferredRead = Column<Row, VESPER_READ, VESPER_USE_DEFERRED>;
template <class Row>
using OptionalDeferredRead = Column<Row, VESPER_READ, VESPER_USE_OPTIONAL | VESPER_USE_DEFERRED>;
template <class Row>
using DeferredWrite = Column<Row, VESPER_WRITE, VESPER_USE_DEFERRED>;
template <class Row>
using DeferredReadWrite = Column<Row, VESPER_READ_WRITE, VESPER_USE_DEFERRED>;
template <class Row>
using DeferredAccumulate = Column<Row, VESPER_ACCUMULATE, VESPER_USE_DEFERRED>;

/** A function of position that a law reads: wind, a magnetic field. Value is a real or Vec3 of one;
 *  the values come in the unit declared. For many positions at once, Evaluate is one call. */
template <class Value, uint32_t flags>
class FieldOf {
 public:
  static constexpr vesper_access kAccess = VESPER_READ;

  constexpr FieldOf(const char* name, const char* kind, const vesper_unit& unit)
      : name_(name), kind_(kind), unit_(unit) {}

  /** The value at a position [m]. */
  template <class Real>
  Value operator()(const Vec3<Real>& at) const {
    const double from[3] = {at.x, at.y, at.z};
    double out[kComponents];
    field_->evaluate(field_->user, 1, from, out);
    if constexpr (kComponents == 1) {
      return static_cast<Value>(out[0]);
    } else {
      return {static_cast<Real>(out[0]), static_cast<Real>(out[1]), static_cast<Real>(out[2])};
    }
  }
  /** out (count x components) at the positions `at` (count x 3) [m]. */
  void Evaluate(uint64_t count, const double* at, double* out) const {
    field_->evaluate(field_->user, count, at, out);
  }
  /** False if the prototype lacks this optional field or nobody gave one. */
  bool present() const requires(flags == VESPER_USE_OPTIONAL) { return field_ != nullptr; }

 private:
  template <class Law>
  friend class detail::Instance;

  static constexpr uint32_t kComponents = detail::RowType<Value>::kComponents;
  static_assert(kComponents == 1 || kComponents == 3, "a field's value is a real or a Vec3");

  constexpr vesper_property_use Use() const {
    return {sizeof(vesper_property_use), VESPER_FIELD, name_, kind_, kComponents, kAccess, unit_,
            flags, 0};
  }
  void Set(const vesper_property& property) {
    field_ = static_cast<const vesper_field*>(property.data);
  }

  const char* name_;
  const char* kind_;
  vesper_unit unit_;
  const vesper_field* field_ = nullptr;
};

template <class Value>
using Field = FieldOf<Value, 0>;
template <class Value>
using OptionalField = FieldOf<Value, VESPER_USE_OPTIONAL>;

/** A number fixed while the law is loaded, in the unit declared; the engine refuses values outside
 *  [minimum, maximum]. Holds its default until the law is loaded, its value from Bind on. */
class Parameter {
 public:
  constexpr Parameter(const char* name, const char* doc, const vesper_unit& unit,
                      double default_value, double minimum, double maximum)
      : desc_{sizeof desc_, 0, name, doc, unit, default_value, minimum, maximum},
        value_(default_value) {}

  constexpr double value() const { return value_; }
  template <std::floating_point Real>
  explicit constexpr operator Real() const {
    return static_cast<Real>(value_);
  }

 private:
  template <class Law>
  friend class detail::Instance;

  vesper_parameter_desc desc_;
  double value_;
};

/** One stage of one step, valid during Advance. */
class Step {
 public:
  /** 0 before the first force evaluation (integrators only), else 1..stage_count. */
  const uint32_t stage;
  const uint32_t stage_count;
  /** Length of the step [time unit of the prototype], > 0. */
  const double dt;
  /** Time at the beginning of the step: index * dt if dt never changed. */
  const double time;
  /** Steps done before this one. */
  const uint64_t index;

  /** Calls body(begin, end) for disjoint ranges that cover [0, count), perhaps at the same time,
   *  and returns when all are done. Ranges do not depend on the number of threads; they are `grain`
   *  long, or as long as the engine likes if 0. If bodies throw, the exception of the first range
   *  that threw is rethrown here. */
  template <std::invocable<uint64_t, uint64_t> Body>
  void ParallelFor(uint64_t count, uint64_t grain, Body&& body) const;

  /** Writes a line to the engine's log (VESPER_LOG_...). Not from within ParallelFor. */
  void Log(uint32_t level, const char* message) const {
    host_.log(host_.context, level, message);
  }

 private:
  template <class Law>
  friend class detail::Instance;

  Step(const vesper_step& step, const vesper_host& host)
      : stage(step.stage), stage_count(step.stage_count), dt(step.dt), time(step.time),
        index(step.index), host_(host) {}

  const vesper_host& host_;
};

template <std::invocable<uint64_t, uint64_t> Body>
void Step::ParallelFor(uint64_t count, uint64_t grain, Body&& body) const {
  struct Call {
    Body& body;
    std::mutex mutex;
    uint64_t failed_at = UINT64_MAX;
    std::exception_ptr failure;

    void Run(uint64_t begin, uint64_t end) noexcept {
      try {
        body(begin, end);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (begin < failed_at) {
          failed_at = begin;
          failure = std::current_exception();
        }
      }
    }
  } call{body, {}, UINT64_MAX, {}};
  host_.parallel_for(
      host_.context, count, grain,
      [](void* user, uint64_t begin, uint64_t end) { static_cast<Call*>(user)->Run(begin, end); },
      &call);
  if (call.failure) std::rethrow_exception(call.failure);
}

namespace detail {

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

/** Runs `action`; what it throws becomes a status. */
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

/** Precision of a law: the argument of its template. */
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

/** The suite that a law names, or void. */
template <class Law>
struct SuiteOf {
  using Type = void;
};
template <class Law>
  requires requires { typename Law::Suite; }
struct SuiteOf<Law> {
  using Type = typename Law::Suite;
};

/** True if one of the columns in what Properties() returns is an Accumulate. */
template <class Properties>
inline constexpr bool kAccumulates = false;
template <class... Columns>
inline constexpr bool kAccumulates<std::tuple<Columns&...>> =
    ((Columns::kAccess == VESPER_ACCUMULATE) || ...);

/** True for a column that the law writes in memory of its own. */
template <class Column>
inline constexpr bool kDefersWrite = false;
template <class Row, vesper_access access, uint32_t flags>
inline constexpr bool kDefersWrite<Column<Row, access, flags>> =
    access != VESPER_READ && (flags & VESPER_USE_DEFERRED) != 0;
template <class Properties>
inline constexpr bool kDefersWrites = false;
template <class... Columns>
inline constexpr bool kDefersWrites<std::tuple<Columns&...>> = (kDefersWrite<Columns> || ...);

/** A law as the engine drives it: the C callbacks and the declarations in C form. */
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
      requires requires(Law& l) { l.PotentialEnergy(); } {
    return Guard(error, [&] { *out = From(law).law_.PotentialEnergy(); });
  }

  static vesper_status Synchronize(vesper_law* law, uint32_t use, vesper_error* error) noexcept {
    return Guard(error, [&] {
      Law& self = From(law).law_;
      uint32_t i = 0;  // of the column
      std::apply([&](auto&... column) { (SynchronizeIf(i++ == use, self, column), ...); },
                 self.Properties());
    });
  }

  static void Destroy(vesper_law* law) noexcept { delete &From(law); }

  explicit Instance(const vesper_host& host) : host_(host) {}

  /** The declarations in C form; lives in the library's static data. */
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
               std::tuple_size_v<decltype(ParametersOf(std::declval<Law&>()))>> parameters_;
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

/** Everything that `vesper_law_library_entry` points to, for both precisions of each law. */
template <template <class> class... Laws>
class Library {
 public:
  explicit Library(const char* name) {
    library_.struct_size = sizeof library_;
    library_.abi_version = VESPER_ABI_VERSION;
    library_.name = name;
    library_.law_count = static_cast<uint32_t>(descs_.size());
    library_.laws = descs_.data();
    if constexpr (!std::is_void_v<Suite>) {
      library_.open = [](const vesper_host*, vesper_suite** out, vesper_error* error) noexcept {
        return Guard(error, [&] { *out = reinterpret_cast<vesper_suite*>(new Suite()); });
      };
      library_.close = [](vesper_suite* suite) noexcept {
        delete reinterpret_cast<Suite*>(suite);
      };
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

}  // namespace detail
}  // namespace vesper

/** Makes the library: VESPER_LAW_LIBRARY("name", Law, MoreLaws...), once, in one source file, at
 *  global scope. The name is that of the file, libvesper_law_NAME.so. */
#define VESPER_LAW_LIBRARY(name, ...)                                                \
  extern "C" VESPER_LAW_EXPORT const vesper_law_library* vesper_law_library_entry() { \
    try {                                                                            \
      static const ::vesper::detail::Library<__VA_ARGS__> library(name);             \
      return library.get();                                                          \
    } catch (...) {                                                                  \
      return nullptr; /* a constructor threw: the engine refuses the library */       \
    }                                                                                \
  }

#endif  // VESPER_LAW_HPP_
