// SPDX-License-Identifier: Apache-2.0
// The ledger: which law changed how much momentum, angular momentum and energy. See docs/ledger.md.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "balance.hpp"
#include "bodies.hpp"
#include "law_library.hpp"

namespace vesper {

/// [J], of what a law's forces derive from.
struct PotentialEnergies {
  double initial = 0;
  double present = 0;
};

struct LedgerLine {
  Balance balance;
  std::optional<PotentialEnergies> potential;  // none: it reports none
};

/// Watches the steps of a schedule. What it books within an advance counts from EndAdvance on: an
/// advance that failed leaves no trace.
class Ledger {
 public:
  /// Opens with nothing booked. Throws as `Bodies` does.
  Ledger(const Prototype& prototype, const Columns& columns);

  /// Takes over which laws there are. What laws that are gone did stays booked as such.
  void Plan(const std::vector<std::unique_ptr<LawLibrary>>& libraries);
  /// Columns are fresh and laws bound. Throws NOT_FOUND if a property of bodies is not bound, or
  /// what a law answers that is asked for its potential energy.
  void BeginAdvance();
  void EndAdvance();

  void BeginStep(double dt);
  void AfterLaw(const LoadedLaw& law);
  /// The laws' shares of this stage are complete.
  void AfterForces(uint32_t stage);
  /// Once in a step, after the last stage.
  void AfterIntegrators();

  /// Rows stand for other bodies than before.
  void ForgetForces();

  /// The line of a law that Plan saw. Columns are fresh and laws bound; throws what a law answers
  /// that is asked for its potential energy.
  LedgerLine Law(vesper_library_id library, uint32_t index) const;
  /// What the client applied, and changed between calls.
  const Balance& client() const { return client_.booked; }
  /// What immovable bodies took, with its sign turned.
  const Balance& ground() const { return ground_.booked; }
  /// What laws did that are unloaded.
  const Balance& unloaded() const { return unloaded_; }
  /// What all bodies had at the end of the last advance more than at the beginning of the first:
  /// the sum of all lines, measured. Otherwise as Law.
  LedgerLine Total() const;

 private:
  /// Forces or torques of one account, gathered over the stages of a step.
  struct Push {
    uint32_t use = kNone;         // of the law, that adds to the sum
    std::vector<double> impulse;  // (bodies x 3), force times time
    std::vector<double> last;     // (bodies x 3), of the last stage of the step before
    Vector last_moment, last_ground_moment;
    bool has_last = false;
  };
  struct Account {
    vesper_library_id library = VESPER_NO_LIBRARY;
    uint32_t index = 0;
    LoadedLaw* law = nullptr;  // null: not a law's
    bool moves = false;        // it writes what the totals are made of
    std::array<Push, 2> pushes;
    Balance booked, pending;
    std::optional<double> initial_potential;  // [J], when the ledger first saw the law's arrays
  };
  /// A sum of forces and the velocity they change; or of torques, and the angular velocity.
  struct Channel {
    uint32_t sum, rate;              // properties, or kNone
    Account* integrator = nullptr;   // of the law that writes `rate`
    std::vector<double> begin = {};  // (bodies x 3), `rate` when the step began
  };

  std::shared_ptr<Account> Find(vesper_library_id library, uint32_t index) const;
  std::shared_ptr<Account> Open(vesper_library_id library, LoadedLaw& law) const;
  void FindIntegrators();
  static double PotentialEnergy(const Account& account);
  /// Visits all who may push: the client and the laws.
  template <class Visit>
  void ForEachGiver(Visit&& visit);
  void Resize();
  bool Active(size_t channel) const;
  Vector Rate(size_t channel, uint64_t row) const;
  bool Yields(size_t channel, uint64_t row) const;
  SiColumn Share(const Account& account, size_t channel) const;
  void Gather(Account& account, size_t channel, uint32_t stage);
  void Settle(Account& account, size_t channel);
  void Book(Account& account, size_t channel, const Balance& taken, const Balance& ground);

  const Prototype& prototype_;
  const Columns& columns_;
  Bodies bodies_;
  std::vector<std::shared_ptr<Account>> laws_;  // in order of loading
  Account client_;
  Account ground_;
  Balance unloaded_;
  std::array<Channel, 2> channels_;
  Balance total_;          // of all bodies, after the law that ran last
  Balance booked_total_;   // at the end of the last advance that counted
  Balance opening_total_;  // at the beginning of the first
  bool opened_ = false;    // these two are known
  bool advancing_ = false;
  double dt_ = 0;  // [s]
};

}  // namespace vesper
