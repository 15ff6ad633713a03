// SPDX-License-Identifier: Apache-2.0
#include "schedule.hpp"

#include <algorithm>
#include <cinttypes>

#include "failure.hpp"
#include "foreign_call.hpp"

namespace vesper {
namespace {

bool SameArrays(const Targets& a, const Targets& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const vesper_property& x, const vesper_property& y) {
                      return x.data == y.data && x.row_count == y.row_count &&
                             x.version == y.version;
                    });
}

/// Returns the function of a field, or the function that also computes slopes.
vesper_field FieldFor(const Law& law, const vesper_property_use& use, const Column& column) {
  if ((use.flags & VESPER_USE_SLOPE) == 0) return column.field;
  const FieldProvider* provider = ConvertedField::ProviderOf(column.field);
  if (provider != nullptr && provider->slopes != nullptr) return provider->slopes->field();
  throw Failure(VESPER_ACCESS_CONFLICT,
                "%s needs the slope of field %s, which the client does not provide",
                law.label().c_str(), use.name)
      .Property(use.name);
}

}  // namespace

void Schedule::Plan(const std::vector<std::unique_ptr<LawLibrary>>& libraries) {
  for (PhaseLaws& phase : phases_) phase.Clear();
  stage_count_ = 1;
  accumulations_.clear();
  scratch_.clear();
  timed_fields_.clear();
  for (uint32_t property = 0; property < columns_.size(); ++property) {
    if (columns_.spec(property).IsAccumulator()) accumulations_.emplace_back(columns_, property);
  }
  std::vector<ScheduledLaw> laws;
  for (const auto& library : libraries) {
    for (const auto& law : library->laws()) laws.push_back({law.get(), library.get()});
    for (const auto& field : library->fields()) {
      if (field->desc->begin_step != nullptr) timed_fields_.push_back(&field->provider);
    }
  }
  for (const ScheduledLaw& scheduled : laws) PlanLaw(scheduled);
  deferred_.Plan(laws);
  for (PhaseLaws& phase : phases_) phase.Plan();
  bound_generation_ = 0;
}

void Schedule::PlanLaw(const ScheduledLaw& scheduled) {
  const vesper_law_desc& desc = scheduled.law->law.desc();
  Phase(desc.phase).Add(scheduled);
  if (desc.phase == VESPER_PHASE_INTEGRATE) stage_count_ = desc.stages;
  for (MatchedUse& matched : scheduled.law->uses) {
    if (matched.IsScratch()) scratch_.push_back(&matched.scratch);
    if (matched.property == kNone || matched.use->access != VESPER_ACCUMULATE) continue;
    FindAccumulation(matched.property).AddShare(*scheduled.law, scheduled.library->id(), matched);
  }
}

Accumulation& Schedule::FindAccumulation(uint32_t property) {
  return *std::find_if(accumulations_.begin(), accumulations_.end(),
                       [property](const Accumulation& a) { return a.property() == property; });
}

void Schedule::Forget() {
  for (const PhaseLaws& phase : phases_) {
    for (const ScheduledLaw& scheduled : phase.laws()) scheduled.law->targets.clear();
  }
  bound_generation_ = 0;
}

void Schedule::Bind() {
  if (IsBound()) return;
  for (const PhaseLaws& phase : phases_) {
    for (const ScheduledLaw& scheduled : phase.laws()) {
      scheduled.OnBehalf(0, [&] { BindLaw(scheduled); });
    }
  }
  bound_generation_ = columns_.generation();
}

void Schedule::BindDeferring() {
  if (deferred_.none()) return;
  for (const PhaseLaws& phase : phases_) {
    for (const ScheduledLaw& scheduled : phase.laws()) {
      if (scheduled.law->Defers()) scheduled.OnBehalf(0, [&] { BindLaw(scheduled); });
    }
  }
}

const char* Schedule::LackedField(const LoadedLaw& law) const {
  for (const MatchedUse& matched : law.uses) {
    const vesper_property_use& use = *matched.use;
    const bool needed = use.scalar_type == VESPER_FIELD && (use.flags & VESPER_USE_OPTIONAL) == 0;
    if (needed && !columns_[matched.property].bound) return use.name;
  }
  return nullptr;
}

void Schedule::BindLaw(const ScheduledLaw& scheduled) {
  LoadedLaw& law = *scheduled.law;
  // A law that keeps properties on a device cannot rest, because its copies would be stale.
  const char* lacked = rest_ && !law.Defers() ? LackedField(law) : nullptr;
  if (lacked != nullptr && !law.resting) {
    scheduled.library->Log(VESPER_LOG_WARNING, law.law.label() +
                                                   " rests, because no law provides the field " +
                                                   lacked + "; load a law that provides it");
  }
  law.resting = lacked != nullptr;
  targets_.clear();
  for (MatchedUse& matched : law.uses) targets_.push_back(Target(law, matched));
  const bool bound_before = law.targets.size() == targets_.size() && !law.targets.empty();
  if (bound_before && SameArrays(law.targets, targets_)) return;
  law.targets = targets_;
  if (law.resting) return;
  try {
    law.runner->Bind(law.targets);
  } catch (...) {
    law.targets.clear();
    throw;
  }
}

/// Returns the array of a use; null data if it is absent. A law that rests lacks a field.
vesper_property Schedule::Target(const LoadedLaw& law, MatchedUse& matched) {
  const vesper_property_use& use = *matched.use;
  vesper_property target{};
  target.struct_size = sizeof target;
  target.scalar_type = use.scalar_type;
  target.name = use.name;
  target.kind = use.kind;
  target.components = use.components;
  target.access = use.access;
  if (matched.IsScratch()) return ScratchTarget(law, matched, target);
  if (matched.property == kNone || !columns_[matched.property].bound) {
    if ((use.flags & VESPER_USE_OPTIONAL) != 0) return target;
    if (law.resting && use.scalar_type == VESPER_FIELD) return target;
    throw Failure(VESPER_NOT_FOUND, "%s: needs property %s, which is not bound; add it first",
                  law.law.label().c_str(), use.name)
        .Property(use.name);
  }
  const Column& column = columns_[matched.property];
  target.data = column.data();
  target.row_count = column.arrays.row_count;
  target.version = deferred_.Version(matched.property, use);
  if (use.scalar_type == VESPER_FIELD) {
    if (matched.field == nullptr) matched.field = std::make_unique<WatchedField>();
    matched.field->Read(FieldFor(law.law, use, column), ValuesPerPlace(use), law.LimitOfFields());
    target.data = matched.field->field();
  }
  if (use.access == VESPER_ACCUMULATE && !FindAccumulation(matched.property).InPlace()) {
    matched.share.Resize(target.row_count * columns_.spec(matched.property).row_size);
    target.data = matched.share.data();
  }
  return target;
}

/// Returns scratch memory for `target`, whose shape is already set.
vesper_property Schedule::ScratchTarget(const LoadedLaw& law, MatchedUse& matched,
                                        vesper_property target) const {
  const uint64_t rows = columns_.row_count(matched.scratch_kind);
  if (rows > kMaxScratchBytes / matched.scratch.row_size()) {
    throw Failure(VESPER_LAW_MISBEHAVED,
                  "%s: SCRATCH %s: %" PRIu64 " rows of %zu bytes, expected %" PRIu64
                  " MiB or less; declare fewer components",
                  law.law.label().c_str(), target.name, rows, matched.scratch.row_size(),
                  kMaxScratchBytes >> 20)
        .Property(target.name);
  }
  matched.scratch.Resize(rows);
  target.data = matched.scratch.data();
  target.row_count = matched.scratch.row_count();
  return target;
}

void Schedule::KeepScratch() {
  for (ScratchColumn* scratch : scratch_) scratch->Keep();
}

void Schedule::RestoreScratch() {
  for (ScratchColumn* scratch : scratch_) scratch->Restore();
}

void Schedule::RunStep(double dt, const StepClock& clock) {
  vesper_step step{};
  step.struct_size = sizeof step;
  step.stage_count = stage_count_;
  step.dt = dt;
  step.time = clock.time();
  step.index = clock.steps;
  for (const FieldProvider* field : timed_fields_) {
    CallForeignQuietly([&] { field->desc->begin_step(field->suite, &step); });
  }
  if (ledger_ != nullptr) ledger_->BeginStep(dt);
  Run(VESPER_PHASE_INTEGRATE, step);
  for (step.stage = 1; step.stage <= stage_count_; ++step.stage) {
    Run(VESPER_PHASE_FORCE, step);
    SumShares(step.stage);
    if (ledger_ != nullptr) ledger_->AfterForces(step.stage);
    Run(VESPER_PHASE_INTEGRATE, step);
  }
  if (ledger_ != nullptr) ledger_->AfterIntegrators();
  step.stage = stage_count_;
  Run(VESPER_PHASE_CONSTRAIN, step);
  Run(VESPER_PHASE_OBSERVE, step);
}

void Schedule::Run(vesper_phase phase, const vesper_step& step) {
  const bool watched = ledger_ != nullptr;
  Phase(phase).Run(pool_, watched || !deferred_.none() ? this : nullptr, watched, step);
}

void Schedule::Before(const ScheduledLaw& law, const vesper_step& step) {
  deferred_.Before(law, step.stage);
  if (law.law->Defers()) law.OnBehalf(step.stage, [&] { BindLaw(law); });
}

void Schedule::After(const ScheduledLaw& law, const vesper_step& step) {
  law.OnBehalf(step.stage, [&] { deferred_.After(law); });
  if (ledger_ == nullptr) return;
  deferred_.SynchronizeAll(step.stage);  // because the ledger reads arrays
  ledger_->AfterLaw(*law.law);
}

void Schedule::SumShares(uint32_t stage) {
  for (const Accumulation& accumulation : accumulations_) {
    if (!columns_[accumulation.property()].bound) continue;
    try {
      accumulation.Sum(pool_);
      if (!accumulation.InPlace()) deferred_.Written(accumulation.property());
    } catch (Failure& failure) {
      failure.Stage(stage);
      throw;
    }
  }
}

}  // namespace vesper
