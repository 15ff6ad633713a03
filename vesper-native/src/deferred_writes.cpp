// SPDX-License-Identifier: Apache-2.0
#include "deferred_writes.hpp"

namespace vesper {
namespace {

bool Defers(const vesper_property_use& use) { return (use.flags & VESPER_USE_DEFERRED) != 0; }

bool Writes(const vesper_property_use& use) {
  return (use.access & (VESPER_WRITE | VESPER_ACCUMULATE)) != 0;
}

}  // namespace

void DeferredWrites::Plan(const std::vector<ScheduledLaw>& laws) {
  none_ = true;
  for (State& state : properties_) {
    state.user = nullptr;
    state.several_users = false;
  }
  for (const ScheduledLaw& scheduled : laws) {
    for (const MatchedUse& matched : scheduled.law->uses) {
      if (matched.property == kNone || !Defers(*matched.use)) continue;
      State& state = properties_[matched.property];
      state.several_users |= state.user != nullptr && state.user != scheduled.library;
      state.user = scheduled.library;
      none_ = false;
    }
  }
}

uint64_t DeferredWrites::Version(uint32_t property, const vesper_property_use& use) const {
  return columns_[property].version + (Defers(use) ? properties_[property].writes : 0);
}

bool DeferredWrites::IsHeld(uint32_t property) const {
  const State& state = properties_[property];
  return state.holder.law != nullptr && state.held_at == columns_[property].version;
}

void DeferredWrites::Before(const ScheduledLaw& law, uint32_t stage) {
  for (const MatchedUse& matched : law.law->uses) {
    if (matched.property == kNone) continue;
    const bool own = properties_[matched.property].holder.library == law.library;
    if (!own || !Defers(*matched.use)) Synchronize(matched.property, stage);
  }
}

void DeferredWrites::After(const ScheduledLaw& law) {
  for (uint32_t i = 0; i < law.law->uses.size(); ++i) {
    const MatchedUse& matched = law.law->uses[i];
    const uint32_t property = matched.property;
    if (property == kNone || !columns_[property].bound || !Writes(*matched.use)) continue;
    if (!Defers(*matched.use)) {
      Written(property);
    } else if (law.law->targets[i].data != columns_[property].data()) {
      law.law->runner->Synchronize(i);  // writes this law's share of a sum, which the engine
                                        // computes next
    } else {
      State& state = properties_[property];
      state.holder = law;
      state.use = i;
      state.held_at = columns_[property].version;
    }
  }
}

void DeferredWrites::Written(uint32_t property) {
  State& state = properties_[property];
  state.holder = {};
  if (state.user != nullptr) ++state.writes;
}

void DeferredWrites::Synchronize(uint32_t property, uint32_t stage) {
  if (!IsHeld(property)) return;
  try {
    Fetch(property, stage);
  } catch (const Failure&) {
    FetchInputs(properties_[property].holder, stage);
    throw;
  }
}

void DeferredWrites::Fetch(uint32_t property, uint32_t stage) {
  State& state = properties_[property];
  state.holder.OnBehalf(stage, [&] { state.holder.law->runner->Synchronize(state.use); });
  state.holder = {};
  if (state.several_users) Written(property);  // other libraries have stale copies
}

void DeferredWrites::FetchInputs(const ScheduledLaw& law, uint32_t stage) {
  for (const MatchedUse& matched : law.law->uses) {
    const uint32_t property = matched.property;
    if (property == kNone || !IsHeld(property)) continue;
    if (properties_[property].holder.law != law.law) Fetch(property, stage);
  }
}

void DeferredWrites::SynchronizeAll(uint32_t stage) {
  if (none_) return;
  for (uint32_t i = 0; i < properties_.size(); ++i) Synchronize(i, stage);
}

void DeferredWrites::SynchronizeHeldBy(const LawLibrary& library) {
  for (uint32_t i = 0; i < properties_.size(); ++i) {
    if (properties_[i].holder.library == &library) Synchronize(i);
    if (properties_[i].holder.library == &library) properties_[i].holder = {};
  }
}

void DeferredWrites::TakeArrays() {
  for (uint32_t i = 0; i < properties_.size(); ++i) Written(i);
}

}  // namespace vesper
