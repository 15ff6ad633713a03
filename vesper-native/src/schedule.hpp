// SPDX-License-Identifier: Apache-2.0
// One step of the simulation: order of the laws, and the arrays of each.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "accumulation.hpp"
#include "columns.hpp"
#include "deferred_writes.hpp"
#include "law_library.hpp"
#include "ledger.hpp"
#include "phase_laws.hpp"
#include "step_clock.hpp"
#include "thread_pool.hpp"

namespace vesper {

class Schedule final : private LawCalls {
 public:
  /// `rest`: laws rest while a field that they read is not bound.
  Schedule(Columns& columns, ThreadPool& pool, bool rest)
      : columns_(columns), deferred_(columns), pool_(pool), rest_(rest) {}

  /// Updates the set of laws. They run in order of phase, then load order; see PhaseLaws for
  /// concurrent laws.
  void Plan(const std::vector<std::unique_ptr<LawLibrary>>& libraries);
  /// Makes the next Bind pass all arrays to all laws, also unchanged ones.
  void Forget();
  /// Passes the current columns to all laws whose arrays changed. Throws NOT_FOUND if an array is
  /// missing, or the failure of a law. Columns must be current.
  void Bind();
  /// Passes the arrays that were written since the last call to the laws with DEFERRED uses.
  /// Columns must be current.
  void BindDeferring();
  /// Returns true if all laws have the current arrays, so that Bind has no work.
  bool IsBound() const { return bound_generation_ == columns_.generation(); }
  /// Returns the tracker of arrays that laws left stale by deferred writes.
  DeferredWrites& deferred() { return deferred_; }
  /// Sets the ledger that records the steps; null: none.
  void SetLedger(Ledger* ledger) { ledger_ = ledger; }
  /// Stores the SCRATCH values of all laws; RestoreScratch restores them.
  void KeepScratch();
  void RestoreScratch();
  /// Runs all laws for one step. Throws the failure of a law, with library, law and stage.
  void RunStep(double dt, const StepClock& clock);

 private:
  void Before(const ScheduledLaw& law, const vesper_step& step) override;
  void After(const ScheduledLaw& law, const vesper_step& step) override;
  void PlanLaw(const ScheduledLaw& scheduled);
  Accumulation& FindAccumulation(uint32_t property);
  void BindLaw(const ScheduledLaw& scheduled);
  /// Returns the name of a field that the law needs and that is not bound; null if there is none.
  const char* LackedField(const LoadedLaw& law) const;
  vesper_property ScratchTarget(const LoadedLaw& law, MatchedUse& matched,
                                vesper_property target) const;
  vesper_property Target(const LoadedLaw& law, MatchedUse& matched);
  PhaseLaws& Phase(vesper_phase phase) { return phases_[phase - VESPER_PHASE_FORCE]; }
  void Run(vesper_phase phase, const vesper_step& step);
  void SumShares(uint32_t stage);

  Columns& columns_;
  DeferredWrites deferred_;
  ThreadPool& pool_;
  bool rest_;
  std::array<PhaseLaws, VESPER_PHASE_OBSERVE> phases_;
  std::vector<ScratchColumn*> scratch_;
  std::vector<const FieldProvider*> timed_fields_;  // fields that depend on the time
  uint32_t stage_count_ = 1;
  std::vector<Accumulation> accumulations_;  // one for each accumulator of the prototype
  Ledger* ledger_ = nullptr;
  Targets targets_;  // arrays of the law that is being bound; kept to avoid allocations
  uint64_t bound_generation_ = 0;
};

}  // namespace vesper
