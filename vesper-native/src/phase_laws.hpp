// SPDX-License-Identifier: Apache-2.0
// The laws of one phase in load order, and the choice of those that run concurrently.
#pragma once

#include <cstdint>
#include <exception>
#include <vector>

#include "failure.hpp"
#include "law_library.hpp"
#include "thread_pool.hpp"

namespace vesper {

/// A law, with its library, which failures name.
struct ScheduledLaw {
  LoadedLaw* law;
  LawLibrary* library;

  /// Runs `body` and attributes an exception to the law, unless the exception reports invalid input
  /// of the client, or a field of another library.
  template <class Body>
  void OnBehalf(uint32_t stage, Body&& body) const {
    try {
      body();
    } catch (FieldFailure& of_field) {
      throw of_field.failure.Stage(stage);
    } catch (Failure& failure) {
      failure.Stage(stage);
      if (failure.status() == VESPER_INVALID_ARGUMENT) throw;
      failure.Library(library->id()).Law(law->index);
      throw;
    }
  }
};

/// Actions before and after the call of each law. They run on the calling thread while no law runs.
class LawCalls {
 public:
  /// Runs before the law; an exception counts as a failure of the law.
  virtual void Before(const ScheduledLaw& law, const vesper_step& step) = 0;
  /// Runs after the law has succeeded.
  virtual void After(const ScheduledLaw& law, const vesper_step& step) = 0;

 protected:
  ~LawCalls() = default;
};

/// The laws of one phase, in waves. Two laws collide if one law writes a property that the other
/// law reads or writes. Laws of the same library also collide, because they may share its suite. A
/// wave contains laws that do not collide, and these laws run concurrently. Each law is in the
/// first wave after the waves of all earlier laws with which it collides. A task graph would not be
/// faster than waves, because a phase has few laws. Most laws collide with no other law (they
/// accumulate) or with all laws (they integrate).
///
/// The result equals that of sequential execution in load order, whatever the number of threads:
/// the same bits, the same failure, the same lines in the log.
class PhaseLaws {
 public:
  void Clear();
  /// Adds a law, which is the last in load order.
  void Add(const ScheduledLaw& added);
  /// Computes the waves; called after the last Add.
  void Plan();
  /// Returns the laws in load order.
  const std::vector<ScheduledLaw>& laws() const { return laws_; }
  /// Runs all laws once. Throws the failure of the first failing law, with library, law and stage.
  /// `calls` may be null. `in_order`: runs no laws concurrently.
  void Run(ThreadPool& pool, LawCalls* calls, bool in_order, const vesper_step& step);

 private:
  void RunInOrder(LawCalls* calls, const vesper_step& step);
  void RunInWaves(ThreadPool& pool, LawCalls* calls, const vesper_step& step);
  void RunWave(const std::vector<uint32_t>& wave, ThreadPool& pool, LawCalls* calls,
               const vesper_step& step);
  template <class Action>
  void Try(uint32_t place, Action&& action);
  void ReleaseLogs();

  std::vector<ScheduledLaw> laws_;
  std::vector<std::vector<uint32_t>> waves_;  // indices into laws_; each wave in load order
  std::vector<std::exception_ptr> failures_;  // the exception of each law, by index in laws_
  uint32_t first_failed_ = 0;  // smallest index in laws_ of a law that failed in a complete wave;
                               // laws_.size() if none failed
};

}  // namespace vesper
