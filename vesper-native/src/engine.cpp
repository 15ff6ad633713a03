// SPDX-License-Identifier: Apache-2.0
#include "engine.hpp"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstring>
#include <span>
#include <string>

#include "failure.hpp"
#include "law_table.hpp"
#include "matching.hpp"
#include "state_hash.hpp"
#include "unit.hpp"
#include "versioned_struct.hpp"

using vesper::Failure;

namespace {

Failure NotBound(const std::string& property) {
  return Failure(VESPER_NOT_FOUND, "property %s is not bound; add it first", property.c_str())
      .Property(property);
}

void WriteEntry(const vesper::LedgerLine& line, vesper_ledger_entry& out) {
  const vesper::Vector& momentum = line.balance.momentum;
  const vesper::Vector& angular_momentum = line.balance.angular_momentum;
  const vesper::PotentialEnergies potential = line.potential.value_or(vesper::PotentialEnergies{});
  const vesper_ledger_entry entry{sizeof entry,
                                  line.potential ? 1u : 0u,
                                  {momentum.x, momentum.y, momentum.z},
                                  {angular_momentum.x, angular_momentum.y, angular_momentum.z},
                                  line.balance.energy,
                                  potential.initial,
                                  potential.present,
                                  line.sizes.impulse,
                                  line.sizes.angular_impulse};
  vesper::WriteStruct(out, entry, "out");
}

}  // namespace

/// Marks the engine as busy during one call.
class vesper_engine::Turn {
 public:
  explicit Turn(const vesper_engine& engine) : engine_(engine) {
    if (engine_.busy_.exchange(true, std::memory_order_acquire)) {
      throw Failure(VESPER_BUSY,
                    "the engine is inside another call; laws and log receivers must "
                    "not call it, nor two threads at a time");
    }
  }
  ~Turn() { engine_.busy_.store(false, std::memory_order_release); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  const vesper_engine& engine_;
};

/// The state of the engine at the beginning of a series of changes. Undo restores this state.
struct vesper_engine::Changes {
  struct Place {
    vesper_library_id library;
    std::vector<uint32_t> intervals;  // interval of each law
  };

  /// Returns the library of a place. It is moved out of the unloaded libraries or out of `loaded`.
  std::unique_ptr<vesper::LawLibrary> Take(
      const Place& place, std::vector<std::unique_ptr<vesper::LawLibrary>>& loaded) {
    for (auto* libraries : {&unloaded, &loaded}) {
      for (auto& library : *libraries) {
        if (library != nullptr && library->id() == place.library) return std::move(library);
      }
    }
    return nullptr;
  }

  std::vector<Place> places;  // places in load order
  std::vector<std::unique_ptr<vesper::LawLibrary>> unloaded;
  std::vector<std::unique_ptr<vesper::LawLibrary>> restored;  // reserved, so that Undo allocates
                                                              // nothing
  std::vector<std::byte> state;
};

vesper_engine::vesper_engine(const vesper::Config& config, const vesper_prototype& prototype)
    : config_(config), prototype_(prototype), pool_(config.threads) {
  schedule_.Plan(libraries_);
}

vesper_engine::~vesper_engine() {
  busy_ = true;  // laws may log during their destruction, and the log must not call the engine
  while (!libraries_.empty()) libraries_.pop_back();
  changes_.reset();
}

void vesper_engine::SetProvider(const vesper_provider_callbacks* callbacks) {
  const Turn turn(*this);
  if (callbacks == nullptr && custom_ == nullptr) return;
  std::unique_ptr<vesper::CustomProvider> custom;
  if (callbacks != nullptr) {
    custom = std::make_unique<vesper::CustomProvider>(*callbacks, prototype_);
  }
  for (uint32_t i = 0; i < columns_.size(); ++i) {
    if (!columns_[i].bound || FieldOwner(i) != nullptr) continue;
    if (custom_ == nullptr) {
      throw Failure(VESPER_ALREADY_EXISTS,
                    "property %s is bound already; remove it before setting a provider",
                    columns_.spec(i).name.c_str())
          .Property(columns_.spec(i).name);
    }
    columns_.Remove(i);
  }
  custom_ = std::move(custom);
}

void vesper_engine::RefreshColumns() {
  if (custom_ != nullptr) {
    custom_->Refresh(columns_, [this](uint32_t property, const vesper::Arrays& arrays) {
      RefuseFieldOfLibrary(property);
      CheckArraysFit(property, arrays);
    });
  }
  columns_.Refresh();
}

/// Returns the index of the property. Throws if a client's provider supplies the arrays, because
/// they cannot be registered then.
uint32_t vesper_engine::RequireRegistered(const char* name) const {
  const uint32_t property = prototype_.Require(name);
  if (custom_ == nullptr) return property;
  throw Failure(VESPER_ACCESS_CONFLICT,
                "property %s comes from the provider that was set; change it there", name)
      .Property(name);
}

void vesper_engine::AddProperty(const char* name, const vesper::Arrays& arrays) {
  const Turn turn(*this);
  const uint32_t property = RequireRegistered(name);
  CheckArraysFit(property, arrays);
  columns_.Add(property, arrays);
}

void vesper_engine::RebindProperty(const char* name, const vesper::Arrays& arrays) {
  const Turn turn(*this);
  const uint32_t property = RequireRegistered(name);
  CheckArraysFit(property, arrays);
  columns_.Rebind(property, arrays);
}

template <class Condition>
void vesper_engine::RefuseIfUsed(uint32_t property, const char* refusal,
                                 Condition&& condition) const {
  for (const auto& library : libraries_) {
    for (const auto& law : library->laws()) {
      for (const vesper::MatchedUse& matched : law->uses) {
        if (matched.property != property || !condition(*matched.use)) continue;
        throw Failure(VESPER_ACCESS_CONFLICT, "property %s %s %s; unload library %s first",
                      matched.use->name, refusal, law->law.label().c_str(), library->name().c_str())
            .Property(matched.use->name)
            .Library(library->id())
            .Law(law->index);
      }
    }
  }
}

void vesper_engine::CheckArraysFit(uint32_t property, const vesper::Arrays& arrays) const {
  if (arrays.indices == nullptr) return;
  RefuseIfUsed(property, "cannot share values through indices: it is written by",
               [](const vesper_property_use& use) { return use.access != VESPER_READ; });
}

void vesper_engine::SetField(const char* name, const vesper_field& field) {
  const Turn turn(*this);
  const uint32_t property = RequireRegistered(name);
  RefuseFieldOfLibrary(property);
  RefuseIfSlopeIsRead(property, "the function of a client");
  columns_.SetField(property, field);
}

/// Refuses a field without slopes if a loaded law needs its slope.
void vesper_engine::RefuseIfSlopeIsRead(uint32_t property, const std::string& provider) const {
  for (const auto& library : libraries_) {
    for (const auto& law : library->laws()) {
      for (const vesper::MatchedUse& matched : law->uses) {
        const bool reads =
            matched.property == property && (matched.use->flags & VESPER_USE_SLOPE) != 0;
        if (!reads) continue;
        throw Failure(VESPER_ACCESS_CONFLICT,
                      "%s needs the slope of field %s, which %s does not provide; provide it by a "
                      "law as text",
                      law->law.label().c_str(), matched.use->name, provider.c_str())
            .Property(matched.use->name);
      }
    }
  }
}

/// Refuses a library that reads the slope of a field without slopes, or provides such a field for a
/// loaded law.
void vesper_engine::RequireSlopes(const vesper::LawLibrary& added) const {
  const auto slopes_unknown = [](const vesper::LawLibrary& library, uint32_t property) {
    return std::ranges::any_of(library.fields(), [property](const auto& field) {
      return field->property == property && field->desc->slopes == nullptr;
    });
  };
  for (const auto& law : added.laws()) {
    for (const vesper::MatchedUse& matched : law->uses) {
      const bool reads = (matched.use->flags & VESPER_USE_SLOPE) != 0;
      if (!reads || matched.property == vesper::kNone) continue;
      const vesper::LawLibrary* owner = FieldOwner(matched.property);
      const bool of_client = owner == nullptr && columns_[matched.property].bound;
      if (owner == nullptr && !of_client) owner = &added;
      if (!of_client && !slopes_unknown(*owner, matched.property)) continue;
      const std::string provider = of_client ? "the client" : "library " + owner->name();
      throw Failure(VESPER_ACCESS_CONFLICT,
                    "%s needs the slope of field %s, which %s does not provide; provide the field "
                    "by a law as text",
                    law->law.label().c_str(), matched.use->name, provider.c_str())
          .Property(matched.use->name)
          .Law(law->index);
    }
  }
  for (const auto& field : added.fields()) {
    if (field->desc->slopes == nullptr) {
      RefuseIfSlopeIsRead(field->property, "library " + added.name());
    }
  }
}

/// Returns the library that provides the field of a FIELD property; null if no library provides it.
const vesper::LawLibrary* vesper_engine::FieldOwner(uint32_t property) const {
  for (const auto& library : libraries_) {
    for (const auto& field : library->fields()) {
      if (field->property == property) return library.get();
    }
  }
  return nullptr;
}

void vesper_engine::RefuseFieldOfLibrary(uint32_t property) const {
  const vesper::LawLibrary* owner = FieldOwner(property);
  if (owner == nullptr) return;
  const std::string& name = columns_.spec(property).name;
  throw Failure(VESPER_ALREADY_EXISTS, "field %s comes from library %s; unload it first",
                name.c_str(), owner->name().c_str())
      .Property(name)
      .Library(owner->id());
}

void vesper_engine::MatchFields(const vesper_law_library& table, vesper::LawLibrary& added) const {
  const std::span fields(table.fields, table.field_count);
  for (uint32_t i = 0; i < fields.size(); ++i) {
    added.fields().push_back(vesper::MatchField(table.name, fields[i], prototype_));
    const uint32_t property = added.fields().back()->property;
    RefuseFieldOfLibrary(property);
    if (!columns_[property].bound) continue;
    throw Failure(VESPER_ALREADY_EXISTS, "library %s: field %s is bound already; remove it first",
                  table.name, fields[i].name)
        .Property(fields[i].name);
  }
}

void vesper_engine::RemoveProperty(const char* name) {
  const Turn turn(*this);
  const uint32_t property = RequireRegistered(name);
  RefuseIfUsed(property, "is needed by", [](const vesper_property_use& use) {
    return (use.flags & VESPER_USE_OPTIONAL) == 0;
  });
  RefuseFieldOfLibrary(property);
  columns_.Remove(property);
}

void vesper_engine::FindProperty(const char* name, vesper_property& out) {
  const Turn turn(*this);
  if (custom_ != nullptr) RefreshColumns();
  const uint32_t property = prototype_.Require(name);
  const vesper::PropertySpec& spec = columns_.spec(property);
  const vesper::Column& column = columns_[property];
  vesper::CheckStructSize<vesper_property>(out.struct_size, "out");
  if (!column.bound) throw NotBound(spec.name);
  FaultIfFails([&] { schedule_.deferred().Synchronize(property); });
  const vesper_property found{
      sizeof found,    spec.type,       spec.name.c_str(),  prototype_.kinds()[spec.kind].c_str(),
      spec.components, spec.law_access, column.arrays.data, column.arrays.row_count,
      column.version};
  vesper::WriteStruct(out, found, "out");
}

std::vector<uint32_t> vesper_engine::BoundProperties(const char* const* names,
                                                     uint32_t count) const {
  std::vector<uint32_t> properties;
  if (names == nullptr) {
    for (uint32_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].bound) properties.push_back(i);
    }
  } else {
    for (uint32_t i = 0; i < count; ++i) properties.push_back(prototype_.Require(names[i]));
  }
  for (uint32_t property : properties) {
    if (!columns_[property].bound) throw NotBound(columns_.spec(property).name);
  }
  return properties;
}

void vesper_engine::Touch(const char* const* names, uint32_t count) {
  const Turn turn(*this);
  for (uint32_t property : BoundProperties(names, count)) columns_.Touch(property);
}

vesper_library_id vesper_engine::Load(vesper_prepared_library& prepared,
                                      const vesper_parameter* parameters, uint32_t count) {
  const Turn turn(*this);
  const vesper_law_library& table = prepared.TableFor(prototype_);
  RefuseLoadedName(table.name);
  if (custom_ != nullptr) RefreshColumns();
  libraries_.push_back(Build(next_library_, table, parameters, count));
  try {
    Plan();
  } catch (...) {
    libraries_.pop_back();
    Plan();
    throw;
  }
  libraries_.back()->Take(&prepared);
  for (const auto& field : libraries_.back()->fields()) {
    columns_.SetField(field->property, field->function->field());
  }
  return next_library_++;
}

void vesper_engine::RefuseLoadedName(const char* name) const {
  for (const auto& library : libraries_) {
    if (library->name() != name) continue;
    throw Failure(VESPER_ALREADY_EXISTS, "library %s is loaded already; unload it first", name)
        .Library(library->id());
  }
}

std::unique_ptr<vesper::LawLibrary> vesper_engine::Build(vesper_library_id id,
                                                         const vesper_law_library& table,
                                                         const vesper_parameter* parameters,
                                                         uint32_t count) {
  auto added = std::make_unique<vesper::LawLibrary>(id, table.name, config_, pool_);
  MatchLaws(table, *added);
  MatchFields(table, *added);
  RequireSlopes(*added);
  CheckConflicts(*added);
  added->Create(table, vesper::ResolveParameters(added->laws(), parameters, count));
  return added;
}

std::unique_ptr<vesper::LawLibrary> vesper_engine::TakeOut(size_t place) {
  for (const auto& field : libraries_[place]->fields()) columns_.Remove(field->property);
  std::unique_ptr<vesper::LawLibrary> taken = std::move(libraries_[place]);
  libraries_.erase(libraries_.begin() + static_cast<ptrdiff_t>(place));
  return taken;
}

void vesper_engine::PutIn(size_t place, std::unique_ptr<vesper::LawLibrary> library) {
  const auto put =
      libraries_.insert(libraries_.begin() + static_cast<ptrdiff_t>(place), std::move(library));
  for (const auto& field : (*put)->fields()) {
    columns_.SetField(field->property, field->function->field());
  }
}

void vesper_engine::Replace(vesper_library_id id, vesper_prepared_library& prepared,
                            const vesper_parameter* parameters, uint32_t count) {
  const Turn turn(*this);
  RefuseIfFaulted();
  const auto place = static_cast<size_t>(FindLibrary(id) - libraries_.cbegin());
  const vesper_law_library& table = prepared.TableFor(prototype_);
  if (custom_ != nullptr) RefreshColumns();
  FaultIfFails([&] { schedule_.deferred().SynchronizeHeldBy(*libraries_[place]); });
  const size_t others = libraries_.size() - 1;
  std::unique_ptr<vesper::LawLibrary> old = TakeOut(place);
  try {
    RefuseLoadedName(table.name);
    auto added = Build(id, table, parameters, count);
    if (ledger_ != nullptr) ledger_->Plan(libraries_);  // closes the accounts of the old laws
    PutIn(place, std::move(added));
    Plan();
  } catch (...) {
    if (libraries_.size() > others) TakeOut(place);
    PutIn(place, std::move(old));
    Plan();
    throw;
  }
  libraries_[place]->Take(&prepared);
  libraries_[place]->TakeScratch(*old);
  SetAside(std::move(old));
}

void vesper_engine::SetAside(std::unique_ptr<vesper::LawLibrary> removed) {
  if (changes_ == nullptr) return;
  const auto is_same = [&](const auto& library) { return library->id() == removed->id(); };
  const bool began =
      std::any_of(changes_->places.begin(), changes_->places.end(),
                  [&](const Changes::Place& place) { return place.library == removed->id(); });
  if (!began || std::any_of(changes_->unloaded.begin(), changes_->unloaded.end(), is_same)) return;
  changes_->unloaded.push_back(std::move(removed));
}

void vesper_engine::Plan() {
  schedule_.Plan(libraries_);
  if (ledger_ != nullptr) ledger_->Plan(libraries_);
}

void vesper_engine::MatchLaws(const vesper_law_library& table, vesper::LawLibrary& added) {
  const std::span laws(table.laws, table.law_count);
  for (uint32_t i = 0; i < laws.size(); ++i) {
    if (laws[i].real_type != 0 && laws[i].real_type != prototype_.real_type()) continue;
    const auto index = static_cast<uint32_t>(added.laws().size());
    try {
      added.laws().push_back(std::make_unique<vesper::LoadedLaw>(
          laws[i], added.id(), index, vesper::MatchUses(laws[i], prototype_, columns_), pool_,
          config_));
    } catch (Failure& failure) {
      failure.Law(index);
      throw;
    }
  }
  if (!added.laws().empty()) return;
  throw Failure(VESPER_TYPE_MISMATCH, "library %s has no law for %s, which prototype %s asks for",
                table.name, vesper::ScalarName(prototype_.real_type()), prototype_.name().c_str());
}

void vesper_engine::CheckConflicts(const vesper::LawLibrary& added) const {
  for (size_t i = 0; i < added.laws().size(); ++i) {
    for (const auto& library : libraries_) {
      for (const auto& law : library->laws()) {
        vesper::CheckCompatible(*law, *added.laws()[i], prototype_);
      }
    }
    for (size_t j = 0; j < i; ++j) {
      vesper::CheckCompatible(*added.laws()[j], *added.laws()[i], prototype_);
    }
  }
}

void vesper_engine::Unload(vesper_library_id id) {
  const Turn turn(*this);
  const auto found = FindLibrary(id);
  FaultIfFails([&] { schedule_.deferred().SynchronizeHeldBy(**found); });
  std::unique_ptr<vesper::LawLibrary> removed =
      TakeOut(static_cast<size_t>(found - libraries_.cbegin()));
  Plan();
  SetAside(std::move(removed));
  if (faulted_ && faulted_library_ == id) {
    faulted_ = false;
    schedule_.Forget();
  }
}

void vesper_engine::BeginChanges() {
  const Turn turn(*this);
  if (changes_ != nullptr) {
    throw Failure(VESPER_ALREADY_EXISTS, "changes are in progress; end them first");
  }
  RefuseIfFaulted();
  auto begun = std::make_unique<Changes>();
  for (const auto& library : libraries_) {
    begun->places.push_back({library->id(), {}});
    for (const auto& law : library->laws()) begun->places.back().intervals.push_back(law->interval);
  }
  begun->unloaded.reserve(libraries_.size());
  begun->restored.reserve(libraries_.size());
  FaultIfFails([&] { schedule_.deferred().SynchronizeAll(); });
  begun->state = vesper::SaveState(State());
  changes_ = std::move(begun);
}

void vesper_engine::EndChanges(bool keep) {
  const Turn turn(*this);
  if (changes_ == nullptr) {
    throw Failure(VESPER_NOT_FOUND, "no changes are in progress; begin them first");
  }
  const std::unique_ptr<Changes> ended = std::move(changes_);
  if (!keep) Undo(*ended);
}

void vesper_engine::Undo(Changes& changes) {
  for (const auto& library : libraries_) {
    for (const auto& field : library->fields()) columns_.Remove(field->property);
  }
  for (const Changes::Place& place : changes.places) {
    changes.restored.push_back(changes.Take(place, libraries_));
    auto& laws = changes.restored.back()->laws();
    for (size_t i = 0; i < laws.size(); ++i) laws[i]->interval = place.intervals[i];
  }
  std::swap(libraries_, changes.restored);
  for (const auto& library : libraries_) {
    for (const auto& field : library->fields()) {
      columns_.SetField(field->property, field->function->field());
    }
  }
  Plan();
  std::erase(changes.restored, nullptr);
  while (!changes.restored.empty()) changes.restored.pop_back();
  faulted_ = false;
  clock_ = vesper::LoadState(changes.state, State());
  schedule_.deferred().TakeArrays();
  if (ledger_ != nullptr) ledger_->ForgetForces();
  schedule_.Forget();
}

void vesper_engine::SetInterval(vesper_library_id id, uint32_t interval) {
  const Turn turn(*this);
  const vesper::LawLibrary& library = **FindLibrary(id);
  for (const auto& law : library.laws()) {
    if (interval != 1) law->RequireInterval(library, interval);
  }
  for (const auto& law : library.laws()) law->interval = interval;
}

std::vector<std::unique_ptr<vesper::LawLibrary>>::const_iterator vesper_engine::FindLibrary(
    vesper_library_id id) const {
  const auto found = std::find_if(libraries_.begin(), libraries_.end(),
                                  [id](const auto& library) { return library->id() == id; });
  if (found != libraries_.end()) return found;
  throw Failure(VESPER_NOT_FOUND, "no library with id %u is loaded", id);
}

const vesper::LoadedLaw& vesper_engine::FindLaw(vesper_library_id id, uint32_t index) const {
  const vesper::LawLibrary& library = **FindLibrary(id);
  if (index < library.laws().size()) return *library.laws()[index];
  throw Failure(VESPER_NOT_FOUND, "library %s has %zu laws, there is no law %u",
                library.name().c_str(), library.laws().size(), index)
      .Library(id);
}

void vesper_engine::LawInfo(vesper_library_id id, uint32_t index, vesper_law_info& out) const {
  const Turn turn(*this);
  const vesper::LawLibrary& library = **FindLibrary(id);
  const vesper::LoadedLaw& loaded = FindLaw(id, index);
  const vesper::Law& law = loaded.law;
  const vesper_law_desc& desc = law.desc();
  const vesper_law_info info{sizeof info,
                             id,
                             library.name().c_str(),
                             desc.name,
                             desc.version,
                             desc.doc,
                             desc.phase,
                             desc.stages,
                             desc.use_count,
                             desc.parameter_count,
                             desc.uses,
                             desc.parameters,
                             law.calls(),
                             law.nanoseconds(),
                             desc.claims,
                             loaded.resting ? 1u : 0u};
  vesper::WriteStruct(out, info, "out");
}

namespace {
template <class T>
void CopyAsDoubles(const std::byte* values, std::span<double> out) {
  for (double& value : out) {
    T element;
    std::memcpy(&element, values, sizeof element);
    value = static_cast<double>(element);
    values += sizeof element;
  }
}
}  // namespace

void vesper_engine::ScratchRow(vesper_library_id id, uint32_t index, uint32_t use, uint64_t row,
                               std::span<double> out) const {
  const Turn turn(*this);
  const vesper::LoadedLaw& law = FindLaw(id, index);
  if (use >= law.uses.size() || !law.uses[use].IsScratch()) {
    throw Failure(VESPER_NOT_FOUND, "law %s has no SCRATCH use %u", law.law.desc().name, use)
        .Library(id);
  }
  const vesper::MatchedUse& matched = law.uses[use];
  if (out.size() != matched.use->components) {
    throw Failure(VESPER_INVALID_ARGUMENT, "law %s, SCRATCH %s: count is %zu, expected %u",
                  law.law.desc().name, matched.use->name, out.size(), matched.use->components)
        .Library(id);
  }
  std::fill(out.begin(), out.end(), 0.0);
  const vesper::ScratchColumn& scratch = matched.scratch;
  if (row >= scratch.row_count()) return;
  const std::byte* values = scratch.data() + row * scratch.row_size();
  switch (matched.use->scalar_type) {
    case VESPER_F32:
      return CopyAsDoubles<float>(values, out);
    case VESPER_F64:
      return CopyAsDoubles<double>(values, out);
    case VESPER_I32:
      return CopyAsDoubles<int32_t>(values, out);
    default:
      return CopyAsDoubles<uint32_t>(values, out);
  }
}

namespace {
void RequireStepLength(double dt) {
  if (!std::isfinite(dt) || dt <= 0) {
    throw Failure(VESPER_INVALID_ARGUMENT, "dt is %g, expected a finite number above 0", dt);
  }
}
}  // namespace

void vesper_engine::SetStepCount(uint64_t steps, double dt) {
  const Turn turn(*this);
  RequireStepLength(dt);
  clock_ = {.steps = steps, .steps_of_dt = steps, .dt = dt, .start_of_dt = 0};
}

void vesper_engine::Advance(double dt, uint32_t steps) {
  const Turn turn(*this);
  RequireStepLength(dt);
  if (ledger_ == nullptr) {
    Bind();
  } else {
    BindFresh();
    ledger_->BeginAdvance();
  }
  schedule_.KeepScratch();
  vesper::StepClock clock = clock_;
  FaultIfFails([&] {
    try {
      for (uint32_t i = 0; i < steps; ++i) {
        schedule_.RunStep(dt, clock);
        clock.Tick(dt);
      }
      if (!config_.deferred) schedule_.deferred().SynchronizeAll();
    } catch (Failure& failure) {
      schedule_.RestoreScratch();
      failure.Within("after " + std::to_string(clock.steps) + " steps");
      throw;
    } catch (...) {
      schedule_.RestoreScratch();
      throw;
    }
  });
  clock_ = clock;
  if (ledger_ != nullptr) ledger_->EndAdvance();
}

void vesper_engine::Bind() {
  RefuseIfFaulted();
  RefreshColumns();
  if (config_.validate) columns_.CheckReferences();
  vesper::DeferredWrites& deferred = schedule_.deferred();
  if (!config_.touches) deferred.TakeArrays();  // the client may have edited any array
  if (!schedule_.IsBound()) FaultIfFails([&] { deferred.SynchronizeAll(); });
  schedule_.Bind();
}

void vesper_engine::BindFresh() {
  Bind();
  FaultIfFails([&] { schedule_.deferred().SynchronizeAll(); });
  schedule_.BindDeferring();
}

void vesper_engine::RefuseIfFaulted() const {
  if (!faulted_) return;
  throw Failure(VESPER_FAULTED,
                "a step failed; restore the arrays and clear the fault, or unload the law")
      .Library(faulted_library_);
}

template <class Body>
void vesper_engine::FaultIfFails(Body&& body) {
  try {
    body();
  } catch (const Failure& failure) {
    Fault(failure.error().library_id);
    throw;
  } catch (...) {  // for example out of memory: the step is incomplete, and no library is the cause
    Fault(VESPER_NO_LIBRARY);
    throw;
  }
}

void vesper_engine::Fault(vesper_library_id library) {
  schedule_.deferred().TakeArrays();
  faulted_ = true;
  faulted_library_ = library;
}

void vesper_engine::Synchronize(const char* const* names, uint32_t count) {
  const Turn turn(*this);
  RefuseIfFaulted();
  for (uint32_t property : BoundProperties(names, count)) {
    FaultIfFails([&] { schedule_.deferred().Synchronize(property); });
  }
}

void vesper_engine::ClearFault() {
  const Turn turn(*this);
  if (!faulted_) return;
  faulted_ = false;
  schedule_.Forget();
}

void vesper_engine::MoveRow(const char* kind, uint64_t from, uint64_t to) {
  const Turn turn(*this);
  const uint32_t moved = prototype_.FindKind(kind);
  if (moved == vesper::kNone) {
    throw Failure(VESPER_NOT_FOUND, "prototype %s has no kind '%.47s'", prototype_.name().c_str(),
                  kind);
  }
  if (to > from) {
    throw Failure(VESPER_INVALID_ARGUMENT,
                  "row %" PRIu64 " of kind %s cannot become row %" PRIu64
                  "; rows move towards the front only",
                  from, kind, to)
        .Row(from);
  }
  if (ledger_ != nullptr) ledger_->ForgetForces();
  for (const auto& library : libraries_) {
    for (const auto& law : library->laws()) {
      for (vesper::MatchedUse& use : law->uses) {
        if (use.IsScratch() && use.scratch_kind == moved) use.scratch.MoveRow(from, to);
      }
    }
  }
}

uint64_t vesper_engine::StateHash() {
  const Turn turn(*this);
  RefuseIfFaulted();
  RefreshColumns();
  FaultIfFails([&] { schedule_.deferred().SynchronizeAll(); });
  return vesper::HashState(clock_.steps, columns_);
}

/// Returns the state to save. The descriptions of prototype and laws in the state must be the same
/// when the state is loaded.
vesper::EngineState vesper_engine::State() const {
  vesper::EngineState state{clock_, prototype_.name(), {}};
  for (const auto& library : libraries_) {
    for (const auto& law : library->laws()) {
      const vesper_law_desc& desc = law->law.desc();
      const std::string prefix = library->name() + "/" + desc.name + " " + desc.version + "/";
      for (vesper::MatchedUse& matched : law->uses) {
        if (!matched.IsScratch()) continue;
        const vesper_property_use& use = *matched.use;
        const std::string type = vesper::DescribeType(use.scalar_type, use.components);
        state.scratch.push_back(
            {prefix + use.name + ": " + type + " per " + use.kind, &matched.scratch});
      }
    }
  }
  return state;
}

std::vector<std::byte> vesper_engine::SaveState() {
  const Turn turn(*this);
  FaultIfFails([&] { schedule_.deferred().SynchronizeAll(); });
  return vesper::SaveState(State());
}

void vesper_engine::LoadState(std::span<const std::byte> saved) {
  const Turn turn(*this);
  clock_ = vesper::LoadState(saved, State());
  schedule_.deferred().TakeArrays();
  if (ledger_ != nullptr) ledger_->ForgetForces();
  schedule_.Forget();
}

void vesper_engine::SetLedger(bool on) {
  const Turn turn(*this);
  std::unique_ptr<vesper::Ledger> ledger;
  if (on) {
    ledger = std::make_unique<vesper::Ledger>(prototype_, columns_);
    ledger->Plan(libraries_);
  }
  ledger_ = std::move(ledger);
  schedule_.SetLedger(ledger_.get());
}

void vesper_engine::LedgerEntry(vesper_library_id id, uint32_t line, vesper_ledger_entry& out) {
  const Turn turn(*this);
  vesper::CheckStructSize<vesper_ledger_entry>(out.struct_size, "out");
  if (ledger_ == nullptr) {
    throw Failure(VESPER_NOT_FOUND,
                  "the ledger is off; switch it on before the steps to be booked");
  }
  if (id != VESPER_NO_LIBRARY) {
    if (FindLaw(id, line).law.desc().potential_energy != nullptr) BindFresh();
    WriteEntry(ledger_->Law(id, line), out);
    return;
  }
  switch (line) {
    case VESPER_LEDGER_CLIENT:
      return WriteEntry({ledger_->client(), {}}, out);
    case VESPER_LEDGER_GROUND:
      return WriteEntry({ledger_->ground(), {}}, out);
    case VESPER_LEDGER_UNLOADED:
      return WriteEntry({ledger_->unloaded(), {}}, out);
    case VESPER_LEDGER_TOTAL:
      BindFresh();
      return WriteEntry(ledger_->Total(), out);
  }
  throw Failure(VESPER_NOT_FOUND, "the ledger has no line %u without a library", line);
}

double vesper_engine::PotentialEnergy(vesper_library_id id, uint32_t index) {
  const Turn turn(*this);
  const vesper::LoadedLaw& law = FindLaw(id, index);
  if (law.law.desc().potential_energy == nullptr) {
    throw Failure(VESPER_NOT_FOUND, "%s reports no potential energy", law.law.label().c_str())
        .Library(id)
        .Law(index);
  }
  BindFresh();
  try {
    return law.PotentialEnergy();
  } catch (Failure& failure) {
    failure.Library(id).Law(index);
    throw;
  }
}
