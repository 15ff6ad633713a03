// SPDX-License-Identifier: Apache-2.0
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
 * A law must have kName, kVersion, kDoc, kPhase, Properties() and Advance(). It may have:
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
 *   void Join(Suite&)       with S() before its laws and dropped after them; handed to each law
 *                           once it has its parameters, in the order of the library
 *
 * The law is default-constructed once when its library is opened, to read the declarations, and
 * once for every engine that loads it. Names and docs must be string literals. An exception thrown
 * by the constructor or by Join at load, by Bind, Advance or PotentialEnergy becomes LAW_FAILED
 * with its what() as message.
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
