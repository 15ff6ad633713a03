// SPDX-License-Identifier: Apache-2.0
// The laws of one phase, in order of loading, and which of them may run at the same time.
#pragma once

#include <cstdint>
#include <exception>
#include <vector>

#include "failure.hpp"
#include "law_library.hpp"
#include "thread_pool.hpp"

namespace vesper {

/// A law and the library to blame for it.
struct ScheduledLaw {
  LoadedLaw* law;
  LawLibrary* library;

  /// Runs `body`; what it throws is laid at the door of the law, unless the client's
  /// input is wrong.
  template <class Body>
  void OnBehalf(uint32_t stage, Body&& body) const {
    try {
      body();
    } catch (Failure& failure) {
      failure.Stage(stage);
      if (failure.status() == VESPER_INVALID_ARGUMENT) throw;
      failure.Library(library->id()).Law(law->index);
      throw;
    }
  }
};

/// What has to be done around calls of laws, on the calling thread, while no law runs.
class LawCalls {
 public:
  /// What it throws fails the law.
  virtual void Before(const ScheduledLaw& law, const vesper_step& step) = 0;
  /// After it did not fail.
  virtual void After(const ScheduledLaw& law, const vesper_step& step) = 0;

 protected:
  ~LawCalls() = default;
};

/// Laws collide if one writes what the other reads or writes, or if they are of one library, since
/// they may share its suite. A wave holds laws that do not collide; a law comes in the first wave
/// after those of all earlier laws that it collides with. Waves, and not a graph of tasks: laws of
/// a phase are few and mostly collide with nobody (they accumulate) or with everybody (they
/// integrate), so that a finer order would gain nothing.
///
/// What happens is what happens if laws run one after the other in order of loading, whatever the
/// number of threads: the same bits, the same failure, the same lines in the log.
class PhaseLaws {
 public:
  void Clear();
  /// The law is the last in order of loading.
  void Add(const ScheduledLaw& added);
  /// Lays the waves, after the last Add.
  void Plan();
  /// In order of loading.
  const std::vector<ScheduledLaw>& laws() const { return laws_; }
  /// Runs all laws once. Throws what the first law that fails throws, with library, law and stage.
  /// `calls` null: nothing has to be done around them. `in_order`: none at the same time.
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
  std::vector<std::vector<uint32_t>> waves_;  // places in laws_; each wave in order of loading
  std::vector<std::exception_ptr> failures_;  // by place in laws_
  uint32_t first_failed_ = 0;  // place in laws_ as of the last wave; their number if none failed
};

}  // namespace vesper
