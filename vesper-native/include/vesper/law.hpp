// SPDX-License-Identifier: Apache-2.0
/* The C++20 layer for authors of physics laws; a law library needs no other header.
 *
 * A law is a class template over the real type. Its members are the properties and parameters that
 * it uses. One macro at the end of the file defines the library, for both precisions:
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
 * A law must have kName, kVersion, kDoc, kPhase, Properties() and Advance(). It may have:
 *   uint32_t kStages        force evaluations per step of an integrator; 1 if absent
 *   uint32_t kFirstStage    1 if an integrator has no work before the first evaluation (stage 0)
 *   std::array<double, 1 + kStages> kForceWeights
 *                           weights of the forces in the velocities; see `force_weights` in law.h
 *   uint32_t kClaims        vesper::Claim values joined with |; none if absent
 *   auto Parameters()       std::tie of its parameters
 *   void Bind()             rebuilds its caches: arrays are new, or the client edited them
 *   double PotentialEnergy()  [J] of the present state
 *   void Synchronize(auto& column)  writes one of its Deferred columns; required if it has any
 *   using Suite = S;        a class of which all laws of the library share one object. Each engine
 *                           has its own object. It is created with S() before the laws, and
 *                           destroyed after them
 *   void Join(Suite&)       receives the shared object. It is called for each law after the
 *                           parameters are set, in the order of the laws in the library
 *
 * The law is default-constructed once when its library is opened, to read the declarations. It is
 * constructed again for each engine that loads it. Names and docs must be string literals. An
 * exception from the constructor or Join at load, or from Bind, Advance or PotentialEnergy, becomes
 * LAW_FAILED with its what() as message.
 */
#ifndef VESPER_LAW_HPP_
#define VESPER_LAW_HPP_

#ifdef __FAST_MATH__
#error "laws are built without -ffast-math: it drops NaN and gives other bits on every machine"
#endif

#include <concepts>
#include <cstdint>
#include <exception>
#include <mutex>

#include "vesper/law.h"
#include "vesper/law_columns.hpp"

namespace vesper {

/** Phase of a step in which a law runs. Order of execution: phase, then load order. */
enum class Phase : vesper_phase {
  kForce = VESPER_PHASE_FORCE,
  kIntegrate = VESPER_PHASE_INTEGRATE,
  kConstrain = VESPER_PHASE_CONSTRAIN,
  kObserve = VESPER_PHASE_OBSERVE,
};

/** Invariants that a law guarantees; the law contract tests check them. */
enum Claim : uint32_t {
  kMomentum = VESPER_CLAIM_MOMENTUM,
  kAngularMomentum = VESPER_CLAIM_ANGULAR_MOMENTUM,
  kTranslation = VESPER_CLAIM_TRANSLATION,
  kRotation = VESPER_CLAIM_ROTATION,
  kEnergy = VESPER_CLAIM_ENERGY,
};

/** A number in the declared unit, constant while the law is loaded. The engine refuses values
 *  outside [minimum, maximum]. Until the law is loaded, the parameter has its default. From the
 *  first Bind on, it has the value that the client gave. */
class Parameter {
 public:
  /** Stores name, one line of documentation and unit, and default and range in that unit. */
  constexpr Parameter(const char* name, const char* doc, const vesper_unit& unit,
                      double default_value, double minimum, double maximum)
      : desc_{sizeof desc_, 0, name, doc, unit, default_value, minimum, maximum},
        value_(default_value) {}

  /** Returns the value, in the declared unit. */
  constexpr double value() const { return value_; }
  /** Returns the value in the law's real type. */
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
  /** 0 before the first force evaluation (integrators only), then 1..stage_count. */
  const uint32_t stage;
  /** Number of force evaluations in this step. */
  const uint32_t stage_count;
  /** Length of the step [time unit of the prototype], > 0. */
  const double dt;
  /** Time at the start of the step: index * dt if dt never changed. */
  const double time;
  /** Number of steps before this one. */
  const uint64_t index;

  /** Calls body(begin, end) for disjoint ranges that cover [0, count), possibly concurrently, and
   *  returns when all calls have returned. Ranges have `grain` elements, or a length that the
   *  engine chooses if `grain` is 0. The ranges do not depend on the number of threads. If calls of
   *  `body` throw exceptions, ParallelFor rethrows the exception of the lowest range. */
  template <std::invocable<uint64_t, uint64_t> Body>
  void ParallelFor(uint64_t count, uint64_t grain, Body&& body) const;

  /** Writes a line to the engine's log (VESPER_LOG_...). Must not be called within ParallelFor. */
  void Log(uint32_t level, const char* message) const { host_.log(host_.context, level, message); }

 private:
  template <class Law>
  friend class detail::Instance;

  Step(const vesper_step& step, const vesper_host& host)
      : stage(step.stage),
        stage_count(step.stage_count),
        dt(step.dt),
        time(step.time),
        index(step.index),
        host_(host) {}

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

}  // namespace vesper

#include "vesper/law_library.hpp"

#endif  // VESPER_LAW_HPP_
