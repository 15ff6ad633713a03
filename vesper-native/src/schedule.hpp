// SPDX-License-Identifier: Apache-2.0
// Which law runs when, on which arrays: one step of the simulation.
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
  Schedule(Columns& columns, ThreadPool& pool)
      : columns_(columns), deferred_(columns), pool_(pool) {}

  /// Takes over which laws there are. Their order in time is phase, then order of loading; see
  /// PhaseLaws for those that run at the same time.
  void Plan(const std::vector<std::unique_ptr<LawLibrary>>& libraries);
  /// Lets every law see its arrays again at the next Bind, changed or not.
  void Forget();
  /// Hands the present columns to all laws whose arrays changed. Throws NOT_FOUND if one is
  /// missing, or what a law answers. Columns are fresh.
  void Bind();
  /// Lets the laws that defer see what was written since their last call. Columns are fresh.
  void BindDeferring();
  /// Whether Bind has anything to do.
  bool IsBound() const { return bound_generation_ == columns_.generation(); }
  /// Arrays that laws left stale.
  DeferredWrites& deferred() { return deferred_; }
  /// Who watches the steps from now on; null: nobody.
  void SetLedger(Ledger* ledger) { ledger_ = ledger; }
  /// Remembers what laws keep in SCRATCH, and takes it back.
  void KeepScratch();
  void RestoreScratch();
  /// Runs all laws once around. Throws what is wrong, with library, law and stage.
  void RunStep(double dt, const StepClock& clock);

 private:
  void Before(const ScheduledLaw& law, const vesper_step& step) override;
  void After(const ScheduledLaw& law, const vesper_step& step) override;
  void PlanLaw(const ScheduledLaw& scheduled);
  Accumulation& FindAccumulation(uint32_t property);
  void BindLaw(LoadedLaw& law);
  vesper_property ScratchTarget(MatchedUse& matched, vesper_property target) const;
  vesper_property Target(const LoadedLaw& law, MatchedUse& matched);
  PhaseLaws& Phase(vesper_phase phase) { return phases_[phase - VESPER_PHASE_FORCE]; }
  void Run(vesper_phase phase, const vesper_step& step);
  void SumShares(uint32_t stage);

  Columns& columns_;
  DeferredWrites deferred_;
  ThreadPool& pool_;
  std::array<PhaseLaws, VESPER_PHASE_OBSERVE> phases_;
  std::vector<ScratchColumn*> scratch_;
  uint32_t stage_count_ = 1;
  std::vector<Accumulation> accumulations_;  // one for each accumulator of the prototype
  Ledger* ledger_ = nullptr;
  Targets targets_;  // of the law being bound; kept for its memory
  uint64_t bound_generation_ = 0;
};

}  // namespace vesper
