// SPDX-License-Identifier: Apache-2.0
#include "phase_laws.hpp"

#include <algorithm>

#include "prototype.hpp"

namespace vesper {
namespace {

/// Returns true if the uses conflict. Two reads do not conflict. Two accumulations do not conflict
/// either, because each law has a separate sum.
bool Collide(const MatchedUse& a, const MatchedUse& b) {
  if (a.property == kNone || a.property != b.property) return false;
  return a.use->access != b.use->access || (a.use->access & VESPER_WRITE) != 0;
}

bool Collide(const ScheduledLaw& a, const ScheduledLaw& b) {
  if (a.library == b.library) return true;
  return std::any_of(a.law->uses.begin(), a.law->uses.end(), [&](const MatchedUse& of_a) {
    return std::any_of(b.law->uses.begin(), b.law->uses.end(),
                       [&](const MatchedUse& of_b) { return Collide(of_a, of_b); });
  });
}

bool IsCalled(const ScheduledLaw& scheduled, const vesper_step& step) {
  return step.stage >= scheduled.law->law.desc().first_stage;
}

void RunLaw(const ScheduledLaw& scheduled, const vesper_step& step) {
  scheduled.OnBehalf(step.stage, [&] { scheduled.law->Run(step); });
}

}  // namespace

void PhaseLaws::Clear() {
  laws_.clear();
  waves_.clear();
}

void PhaseLaws::Add(const ScheduledLaw& added) { laws_.push_back(added); }

void PhaseLaws::Plan() {
  waves_.clear();
  std::vector<size_t> wave_of;
  for (uint32_t i = 0; i < laws_.size(); ++i) {
    size_t wave = 0;
    for (uint32_t earlier = 0; earlier < i; ++earlier) {
      if (Collide(laws_[earlier], laws_[i])) wave = std::max(wave, wave_of[earlier] + 1);
    }
    wave_of.push_back(wave);
    if (wave == waves_.size()) waves_.emplace_back();
    waves_[wave].push_back(i);
  }
  failures_.assign(laws_.size(), nullptr);
}

void PhaseLaws::Run(ThreadPool& pool, LawCalls* calls, bool in_order, const vesper_step& step) {
  const bool together = !in_order && pool.threads() > 1 && waves_.size() < laws_.size();
  if (together) {
    RunInWaves(pool, calls, step);
  } else {
    RunInOrder(calls, step);
  }
}

void PhaseLaws::RunInOrder(LawCalls* calls, const vesper_step& step) {
  for (const ScheduledLaw& scheduled : laws_) {
    if (!IsCalled(scheduled, step)) continue;
    if (calls != nullptr) calls->Before(scheduled, step);
    RunLaw(scheduled, step);
    if (calls != nullptr) calls->After(scheduled, step);
  }
}

void PhaseLaws::RunInWaves(ThreadPool& pool, LawCalls* calls, const vesper_step& step) {
  for (const ScheduledLaw& scheduled : laws_) scheduled.library->HoldLog();
  first_failed_ = static_cast<uint32_t>(laws_.size());
  for (const std::vector<uint32_t>& wave : waves_) RunWave(wave, pool, calls, step);
  ReleaseLogs();
  if (first_failed_ == laws_.size()) return;
  const std::exception_ptr failure = failures_[first_failed_];
  std::fill(failures_.begin(), failures_.end(), nullptr);
  std::rethrow_exception(failure);
}

/// Runs a wave. Runs no law that is later in load order than a failed law. Laws that are earlier in
/// load order may be in a later wave. They still run, because they may fail, too, and the first
/// failure in load order counts.
void PhaseLaws::RunWave(const std::vector<uint32_t>& wave, ThreadPool& pool, LawCalls* calls,
                        const vesper_step& step) {
  const auto try_for = [&](uint32_t place, auto&& action) {
    if (IsCalled(laws_[place], step)) Try(place, [&] { action(laws_[place]); });
  };
  const auto for_each = [&](auto&& action) {
    for (const uint32_t place : wave) try_for(place, action);
  };
  if (calls != nullptr) for_each([&](const ScheduledLaw& law) { calls->Before(law, step); });
  auto run = [&](uint64_t i) {
    try_for(wave[i], [&](const ScheduledLaw& law) { RunLaw(law, step); });
  };
  pool.ForEach(wave.size(), run);
  if (calls != nullptr) for_each([&](const ScheduledLaw& law) { calls->After(law, step); });
  for (const uint32_t place : wave) {
    if (failures_[place] != nullptr) first_failed_ = std::min(first_failed_, place);
  }
}

/// Runs an action for a law. Does nothing if this law has failed, or if a law before it in load
/// order has failed in an earlier wave.
template <class Action>
void PhaseLaws::Try(uint32_t place, Action&& action) {
  if (place > first_failed_ || failures_[place] != nullptr) return;
  try {
    action();
  } catch (...) {
    failures_[place] = std::current_exception();
  }
}

/// Passes held log lines to the log, except those of laws that would not have run in sequential
/// execution.
void PhaseLaws::ReleaseLogs() {
  for (uint32_t place = 0; place < laws_.size(); ++place) {
    if (place <= first_failed_) {
      laws_[place].library->ReleaseLog();
    } else {
      laws_[place].library->DropLog();
    }
  }
}

}  // namespace vesper
