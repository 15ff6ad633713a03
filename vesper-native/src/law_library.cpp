// SPDX-License-Identifier: Apache-2.0
#include "law_library.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <limits>

#include "converting_runner.hpp"
#include "foreign_call.hpp"
#include "loop_bound.hpp"
#include "unit.hpp"

namespace vesper {
namespace {

constexpr double kImmenseField = 0x1p333;  // limit of `vesper_engine_config.limit_values`

}  // namespace

LoadedLaw::LoadedLaw(const vesper_law_desc& desc, vesper_library_id library, uint32_t law_index,
                     std::vector<MatchedUse> matched, ThreadPool& pool, const Config& config)
    : law(desc, Running(config.running, pool, library, law_index)),
      index(law_index),
      uses(std::move(matched)),
      runner(MakeRunner(law, pool, config)),
      limit_of_fields_(desc.real_type == VESPER_F32 ? std::numeric_limits<float>::max()
                       : config.limit_values        ? kImmenseField
                                                    : std::numeric_limits<double>::infinity()) {
  std::vector<UnitRatio> ratios;
  for (const MatchedUse& use : uses) ratios.push_back(use.to_law);
  const auto is_one = [](const UnitRatio& ratio) { return ratio.IsOne(); };
  if (std::all_of(ratios.begin(), ratios.end(), is_one)) return;
  runner = MakeConvertingRunner(law, std::move(runner), std::move(ratios));
}

bool LoadedLaw::Writes(uint32_t property) const {
  return std::any_of(uses.begin(), uses.end(), [property](const MatchedUse& matched) {
    return matched.property == property && (matched.use->access & VESPER_WRITE) != 0;
  });
}

bool LoadedLaw::Defers() const {
  return std::any_of(uses.begin(), uses.end(), [](const MatchedUse& matched) {
    return (matched.use->flags & VESPER_USE_DEFERRED) != 0;
  });
}

void LoadedLaw::Run(const vesper_step& step) {
  if (resting) {
    AddNothing();
    return;
  }
  for (const MatchedUse& use : uses) {
    if (use.field != nullptr) use.field->BeginCall();
  }
  try {
    RunDue(step);
  } catch (const Failure& failure) {
    BlameFields(failure);
    throw;
  }
}

void LoadedLaw::BlameFields(const Failure& failure) const {
  const bool computed =
      failure.status() == VESPER_LAW_FAILED || failure.status() == VESPER_LAW_MISBEHAVED;
  if (!computed) return;
  for (const MatchedUse& use : uses) {
    if (use.field == nullptr) continue;
    if (auto blamed = use.field->Blamed(use.use->name, law.label())) throw FieldFailure{*blamed};
  }
}

void LoadedLaw::RunDue(const vesper_step& step) {
  if (interval == 1) {
    runner->Advance(step);
    CheckMinima();
  } else if (interval == 0 || step.index % interval != 0) {
    AddNothing();
  } else {
    runner->Advance(step);
    MultiplyAdded();
  }
}

void LoadedLaw::AddNothing() {
  for (const vesper_property& target : targets) {
    if (target.access != VESPER_ACCUMULATE || target.row_count == 0) continue;
    const uint64_t values = target.row_count * target.components;
    std::memset(target.data, 0, values * ScalarSize(target.scalar_type));
  }
}

void LoadedLaw::MultiplyAdded() {
  const UnitRatio factor{static_cast<double>(interval), 1};
  for (const vesper_property& target : targets) {
    if (target.access != VESPER_ACCUMULATE) continue;
    const uint64_t values = target.row_count * target.components;
    Convert(target.scalar_type, target.data, target.data, factor, values);
    const uint64_t bad = FindNonFinite(target.scalar_type, target.data, values);
    if (bad == kNotFound) continue;
    const uint64_t row = bad / target.components;
    throw Failure(VESPER_LAW_MISBEHAVED,
                  "%s: property %s, row %" PRIu64 ": what it adds overflows for %u steps at once",
                  law.label().c_str(), target.name, row, interval)
        .Property(target.name)
        .Row(row);
  }
}

void LoadedLaw::CheckMinima() const {
  for (size_t i = 0; i < uses.size(); ++i) {
    if (!uses[i].minimum || law.Defers(i)) continue;
    const vesper_property& target = targets[i];
    const uint64_t values = target.row_count * target.components;
    const uint64_t bad = FindBelow(target.scalar_type, target.data, values, *uses[i].minimum);
    if (bad == kNotFound) continue;
    const uint64_t row = bad / target.components;
    throw Failure(VESPER_LAW_MISBEHAVED,
                  "%s: property %s, row %" PRIu64 ": wrote %g, expected %g or more",
                  law.label().c_str(), target.name, row,
                  ValueAt(target.scalar_type, target.data, bad), *uses[i].minimum)
        .Property(target.name)
        .Row(row);
  }
}

void LoadedLaw::RequireInterval(const LawLibrary& library, uint32_t wanted) const {
  const bool writes = std::any_of(uses.begin(), uses.end(), [](const MatchedUse& matched) {
    return (matched.use->access & VESPER_WRITE) != 0;
  });
  const bool keeps = std::any_of(uses.begin(), uses.end(), [](const MatchedUse& matched) {
    return matched.use->access != VESPER_READ && (matched.use->flags & VESPER_USE_DEFERRED) != 0;
  });
  const char* reason = keeps                                    ? "keeps properties on a device"
                       : wanted == 0                            ? nullptr
                       : law.desc().phase != VESPER_PHASE_FORCE ? "is no force law"
                       : writes                                 ? "writes properties"
                                                                : nullptr;
  if (reason == nullptr) return;
  throw Failure(VESPER_ACCESS_CONFLICT, "%s %s, so it cannot run in every %u. step only",
                law.label().c_str(), reason, wanted)
      .Library(library.id())
      .Law(index);
}

LawLibrary::LawLibrary(vesper_library_id id, std::string name, const Config& config,
                       ThreadPool& pool)
    : id_(id), name_(std::move(name)), config_(config), pool_(pool), host_{} {
  host_.struct_size = sizeof host_;
  host_.context = this;
  host_.log = HostLog;
  host_.parallel_for = HostParallelFor;
}

LawLibrary::~LawLibrary() {
  while (!laws_.empty()) laws_.pop_back();
  if (suite_ != nullptr) CallForeignQuietly([this] { close_(suite_); });
}

void LawLibrary::Create(const vesper_law_library& table,
                        const std::vector<std::vector<double>>& parameters) {
  host_.user = table.user;
  if (table.open != nullptr) {
    const std::string label = "library " + name_;
    vesper_suite* suite = nullptr;
    CallForeign(label, [&](vesper_error* error) { return table.open(&host_, &suite, error); });
    if (suite == nullptr) {
      throw Failure(VESPER_LAW_MISBEHAVED, "%s: open returned OK but no suite", label.c_str());
    }
    suite_ = suite;
    close_ = table.close;
  }
  for (const auto& field : fields_) {
    const vesper_field source{sizeof source, 0, suite_, field->desc->evaluate};
    field->provider = {id_, name_, static_cast<uint32_t>(laws_.size()), field->desc, suite_};
    field->function = std::make_unique<ConvertedField>(source, field->from_library,
                                                       field->desc->components, &field->provider);
    if (field->desc->slopes == nullptr) continue;
    const vesper_field with_slopes{sizeof with_slopes, 0, suite_, field->desc->slopes};
    field->slopes = std::make_unique<ConvertedField>(with_slopes, field->from_library,
                                                     4 * field->desc->components, &field->provider);
    field->provider.slopes = field->slopes.get();
  }
  for (size_t i = 0; i < laws_.size(); ++i) {
    try {
      laws_[i]->law.Create(host_, suite_, parameters[i]);
    } catch (Failure& failure) {
      failure.Law(laws_[i]->index);
      throw;
    }
  }
}

namespace {
bool HaveSameLayout(const MatchedUse& a, const MatchedUse& b) {
  return a.IsScratch() && b.IsScratch() && a.scratch_kind == b.scratch_kind &&
         a.use->scalar_type == b.use->scalar_type && a.use->components == b.use->components &&
         std::strcmp(a.use->name, b.use->name) == 0;
}
}  // namespace

void LawLibrary::TakeScratch(LawLibrary& old) noexcept {
  for (const auto& law : laws_) {
    for (const auto& before : old.laws_) {
      if (std::strcmp(law->law.desc().name, before->law.desc().name) != 0) continue;
      for (MatchedUse& use : law->uses) {
        for (MatchedUse& source : before->uses) {
          if (HaveSameLayout(use, source)) std::swap(use.scratch, source.scratch);
        }
      }
    }
  }
}

void LawLibrary::HostLog(void* context, uint32_t level, const char* message) {
  auto& library = *static_cast<LawLibrary*>(context);
  if (message == nullptr) return;
  char line[512];
  std::snprintf(line, sizeof line, "%s: %s", library.name_.c_str(), message);
  if (library.hold_log_) {
    library.Hold(level, line);
  } else {
    library.config_.Log(level, line);
  }
}

void LawLibrary::Hold(uint32_t level, const char* line) noexcept {
  const size_t size = held_log_.size();
  try {
    held_log_.append(1, static_cast<char>(level)).append(line).append(1, '\0');
  } catch (...) {
    held_log_.resize(size);  // if memory is exhausted, the line is dropped and the law continues
  }
}

void LawLibrary::ReleaseLog() {
  for (size_t at = 0; at < held_log_.size();) {
    const auto level = static_cast<unsigned char>(held_log_[at++]);
    const char* line = held_log_.c_str() + at;
    config_.Log(level, line);
    at += std::strlen(line) + 1;
  }
  DropLog();
}

void LawLibrary::DropLog() {
  hold_log_ = false;
  held_log_.clear();
}

void LawLibrary::HostParallelFor(void* context, uint64_t count, uint64_t grain, RangeBody body,
                                 void* user) {
  if (RefuseLoop(count)) return;
  static_cast<LawLibrary*>(context)->pool_.ParallelFor(count, grain, body, user);
}

}  // namespace vesper
