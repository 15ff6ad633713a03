// SPDX-License-Identifier: Apache-2.0
#include "ledger.hpp"

#include <algorithm>

#include "failure.hpp"

namespace vesper {
namespace {

constexpr size_t kForces = 0;
constexpr size_t kTorques = 1;

/// Returns the weight of a stage's forces in the integrator's step. Stage 0 stands for the forces
/// at the end of the previous step.
double ForceWeight(const vesper_law_desc& integrator, uint32_t stage) {
  if (integrator.force_weights != nullptr) return integrator.force_weights[stage];
  return stage == 0 ? 0 : 1.0 / integrator.stages;
}

void Add(std::vector<double>& rows, uint64_t row, const Vector& v) {
  rows[3 * row] += v.x;
  rows[3 * row + 1] += v.y;
  rows[3 * row + 2] += v.z;
}

void Put(std::vector<double>& rows, uint64_t row, const Vector& v) {
  rows[3 * row] = v.x;
  rows[3 * row + 1] = v.y;
  rows[3 * row + 2] = v.z;
}

Vector Get(const std::vector<double>& rows, uint64_t row) {
  return {rows[3 * row], rows[3 * row + 1], rows[3 * row + 2]};
}

}  // namespace

Ledger::Ledger(const Prototype& prototype, const Columns& columns)
    : prototype_(prototype),
      columns_(columns),
      bodies_(prototype, columns),
      channels_{Channel{.sum = bodies_.force(), .rate = bodies_.velocity()},
                Channel{.sum = bodies_.torque(), .rate = bodies_.angular_velocity()}} {}

void Ledger::Plan(const std::vector<std::unique_ptr<LawLibrary>>& libraries) {
  std::vector<std::shared_ptr<Account>> laws;
  for (const auto& library : libraries) {
    for (const auto& law : library->laws()) {
      const auto known = Find(library->id(), law->index);
      laws.push_back(known != nullptr ? known : Open(library->id(), *law));
    }
  }
  laws_.swap(laws);
  for (const auto& account : laws) {
    if (Find(account->library, account->index) == nullptr) unloaded_ += account->booked;
  }
  FindIntegrators();
  ForgetForces();
}

std::shared_ptr<Ledger::Account> Ledger::Find(vesper_library_id library, uint32_t index) const {
  for (const auto& account : laws_) {
    if (account->library == library && account->index == index) return account;
  }
  return nullptr;
}

std::shared_ptr<Ledger::Account> Ledger::Open(vesper_library_id library, LoadedLaw& law) const {
  auto account = std::make_shared<Account>();
  account->library = library;
  account->index = law.index;
  account->law = &law;
  for (uint32_t i = 0; i < law.uses.size(); ++i) {
    const MatchedUse& matched = law.uses[i];
    if (matched.property == kNone) continue;
    if ((matched.use->access & VESPER_WRITE) != 0 && bodies_.Count(matched.property)) {
      account->moves = true;
    }
    if (matched.use->access != VESPER_ACCUMULATE) continue;
    for (size_t channel = 0; channel < channels_.size(); ++channel) {
      if (channels_[channel].sum == matched.property) account->pushes[channel].use = i;
    }
  }
  return account;
}

void Ledger::FindIntegrators() {
  for (Channel& channel : channels_) {
    channel.integrator = nullptr;
    if (channel.sum == kNone || channel.rate == kNone) continue;
    for (const auto& account : laws_) {
      const bool integrates = account->law->law.desc().phase == VESPER_PHASE_INTEGRATE;
      if (integrates && account->law->Writes(channel.rate)) channel.integrator = account.get();
    }
  }
}

template <class Visit>
void Ledger::ForEachGiver(Visit&& visit) {
  visit(client_);
  for (const auto& account : laws_) visit(*account);
}

void Ledger::BeginAdvance() {
  if (advancing_) ForgetForces();  // true: the last advance failed before its end
  bodies_.Bind();
  for (const auto& account : laws_) {
    account->pending = {};
    account->pending_sizes = {};
    if (account->law->law.desc().potential_energy == nullptr) continue;
    if (!account->initial_potential) account->initial_potential = PotentialEnergy(*account);
  }
  Resize();
  total_ = bodies_.Total();
  if (!opened_) booked_total_ = opening_total_ = total_;
  opened_ = true;
  ground_.pending = {};
  client_.pending = total_ - booked_total_;
  advancing_ = true;
}

double Ledger::PotentialEnergy(const Account& account) {
  try {
    return account.law->PotentialEnergy();
  } catch (Failure& failure) {
    failure.Library(account.library).Law(account.law->index);
    throw;
  }
}

/// Allocates space for the present number of bodies. Discards the forces of the last stage if this
/// number has changed, because they may belong to other bodies than the present rows.
void Ledger::Resize() {
  const size_t size = 3 * bodies_.count();
  if (channels_[kForces].begin.size() != size) ForgetForces();
  for (size_t i = 0; i < channels_.size(); ++i) {
    channels_[i].begin.resize(size);
    ForEachGiver([&](Account& account) {
      account.pushes[i].impulse.resize(size);
      account.pushes[i].last.resize(size);
    });
  }
}

void Ledger::ForgetForces() {
  ForEachGiver([](Account& account) {
    for (Push& push : account.pushes) push.has_last = false;
  });
}

void Ledger::BeginStep(double dt) {
  dt_ = dt * prototype_.time_unit().scale;
  for (size_t i = 0; i < channels_.size(); ++i) {
    if (!Active(i)) continue;
    for (uint64_t row = 0; row < bodies_.count(); ++row) Put(channels_[i].begin, row, Rate(i, row));
    ForEachGiver([i](Account& account) {
      std::vector<double>& impulse = account.pushes[i].impulse;
      std::fill(impulse.begin(), impulse.end(), 0.0);
    });
  }
}

void Ledger::AfterLaw(const LoadedLaw& law) {
  const auto account = std::find_if(laws_.begin(), laws_.end(),
                                    [&law](const auto& other) { return other->law == &law; });
  if (!(*account)->moves) return;
  const Balance before = total_;
  total_ = bodies_.Total();
  (*account)->pending += total_ - before;
}

void Ledger::AfterForces(uint32_t stage) {
  for (size_t i = 0; i < channels_.size(); ++i) {
    if (Active(i)) ForEachGiver([&](Account& account) { Gather(account, i, stage); });
  }
}

void Ledger::AfterIntegrators() {
  for (size_t i = 0; i < channels_.size(); ++i) {
    if (Active(i)) ForEachGiver([&](Account& account) { Settle(account, i); });
  }
}

/// Returns true if the channel's forces have an effect: their property is bound, and a law
/// integrates it.
bool Ledger::Active(size_t channel) const {
  const Channel& c = channels_[channel];
  return c.integrator != nullptr && columns_[c.sum].bound && columns_[c.rate].bound;
}

Vector Ledger::Rate(size_t channel, uint64_t row) const {
  return channel == kForces ? bodies_.Velocity(row) : bodies_.AngularVelocity(row);
}

/// Returns true if the body can move (or rotate). The impulses of such a body belong to the body.
/// Impulses on other bodies belong to the ground.
bool Ledger::Yields(size_t channel, uint64_t row) const {
  return channel == kForces ? bodies_.Moves(row) : bodies_.Turns(row);
}

/// Returns the share that the account added to the channel's sum in this stage; null data if it
/// added nothing.
SiColumn Ledger::Share(const Account& account, size_t channel) const {
  const uint32_t sum = channels_[channel].sum;
  if (account.law != nullptr) {
    const uint32_t use = account.pushes[channel].use;
    return use == kNone ? SiColumn{} : bodies_.View(sum, account.law->targets[use].data);
  }
  const uint32_t applied = columns_.spec(sum).initial_from;
  if (applied == kNone || !columns_[applied].bound) return {};
  return bodies_.View(applied, columns_[applied].data());
}

/// Adds the forces of one stage to the account's impulses, and books their moments about the
/// origin.
void Ledger::Gather(Account& account, size_t channel, uint32_t stage) {
  const SiColumn share = Share(account, channel);
  if (share.data == nullptr) return;
  Push& push = account.pushes[channel];
  const vesper_law_desc& integrator = channels_[channel].integrator->law->law.desc();
  const double time = ForceWeight(integrator, stage) * dt_;
  const double last_time = stage == 1 ? ForceWeight(integrator, 0) * dt_ : 0;
  const bool keeps = stage == integrator.stages && ForceWeight(integrator, 0) != 0;
  Vector moment, ground_moment;
  double turning = 0;
  for (uint64_t row = 0; row < bodies_.count(); ++row) {
    const Vector force = share.Row(row);
    const Vector last = push.has_last ? Get(push.last, row) : force;
    Add(push.impulse, row, force * time + last * last_time);
    const Vector turn = channel == kForces ? Cross(bodies_.Position(row), force) : force;
    (Yields(channel, row) ? moment : ground_moment) += turn;
    turning += Length(turn);
    if (keeps) Put(push.last, row, force);
  }
  if (!push.has_last) {
    push.last_moment = moment;
    push.last_ground_moment = ground_moment;
    push.last_turning = turning;
  }
  Balance taken, ground;
  taken.angular_momentum = moment * time + push.last_moment * last_time;
  ground.angular_momentum = ground_moment * time + push.last_ground_moment * last_time;
  account.pending_sizes.angular_impulse += turning * time + push.last_turning * last_time;
  Book(account, channel, taken, ground);
  if (!keeps) return;
  push.last_moment = moment;
  push.last_ground_moment = ground_moment;
  push.last_turning = turning;
  push.has_last = true;
}

/// Records the impulses of a whole step, and their work. The work is computed with the mean
/// velocity of the step.
void Ledger::Settle(Account& account, size_t channel) {
  if (Share(account, channel).data == nullptr) return;
  Balance taken, ground;
  for (uint64_t row = 0; row < bodies_.count(); ++row) {
    const Vector impulse = Get(account.pushes[channel].impulse, row);
    const Vector middle = (Get(channels_[channel].begin, row) + Rate(channel, row)) * 0.5;
    Balance& side = Yields(channel, row) ? taken : ground;
    if (channel == kForces) {
      side.momentum += impulse;
      account.pending_sizes.impulse += Length(impulse);
    }
    side.energy += Dot(impulse, middle);
  }
  Book(account, channel, taken, ground);
}

/// Moves `taken` from the account of the integrator to this account. `taken` is the part of the
/// integrator's change of the bodies that the forces of this account caused. Books `ground`, the
/// impulses on immovable bodies, for the ground.
void Ledger::Book(Account& account, size_t channel, const Balance& taken, const Balance& ground) {
  account.pending += taken + ground;
  channels_[channel].integrator->pending -= taken;
  ground_.pending -= ground;
}

void Ledger::EndAdvance() {
  const auto book = [](Account& account) {
    account.booked += account.pending;
    account.booked_sizes += account.pending_sizes;
  };
  ForEachGiver(book);
  book(ground_);
  booked_total_ = total_;
  advancing_ = false;
}

LedgerLine Ledger::Law(vesper_library_id library, uint32_t index) const {
  const auto account = Find(library, index);
  LedgerLine line{account->booked, std::nullopt, account->booked_sizes};
  if (account->law->law.desc().potential_energy == nullptr) return line;
  const double present = PotentialEnergy(*account);
  line.potential = {account->initial_potential.value_or(present), present};
  return line;
}

LedgerLine Ledger::Total() const {
  LedgerLine total{booked_total_ - opening_total_, std::nullopt};
  for (const auto& account : laws_) {
    const auto potential = Law(account->library, account->index).potential;
    if (!potential) continue;
    if (!total.potential) total.potential.emplace();
    total.potential->initial += potential->initial;
    total.potential->present += potential->present;
  }
  return total;
}

}  // namespace vesper
