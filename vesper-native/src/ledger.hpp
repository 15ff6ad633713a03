// SPDX-License-Identifier: Apache-2.0
// The ledger: changes of momentum, angular momentum and energy by each law. See docs/ledger.md.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "balance.hpp"
#include "bodies.hpp"
#include "law_library.hpp"

namespace vesper {

/// Potential energies [J] of a law's forces.
struct PotentialEnergies {
  double initial = 0;
  double present = 0;
};

/// Sums of magnitudes, to which sums of vectors are compared, for example to find rounding errors.
struct ImpulseSizes {
  double impulse = 0;          // [kg*m/s]
  double angular_impulse = 0;  // [kg*m^2/s], about the origin

  ImpulseSizes& operator+=(const ImpulseSizes& other) {
    impulse += other.impulse;
    angular_impulse += other.angular_impulse;
    return *this;
  }
};

struct LedgerLine {
  Balance balance;
  std::optional<PotentialEnergies> potential;  // none: the law reports no potential energy
  ImpulseSizes sizes = {};
};

/// Records the contribution of each law during the steps of an advance. EndAdvance commits the
/// entries of an advance; a failed advance leaves no entries.
class Ledger {
 public:
  /// Creates an empty ledger. Throws as `Bodies` does.
  Ledger(const Prototype& prototype, const Columns& columns);

  /// Updates the set of laws. The contributions of unloaded laws are kept, as one sum.
  void Plan(const std::vector<std::unique_ptr<LawLibrary>>& libraries);
  /// Starts an advance. Columns must be current and laws bound. Throws NOT_FOUND if a required
  /// property of bodies is not bound, or the failure of a law when its potential energy is
  /// computed.
  void BeginAdvance();
  void EndAdvance();

  void BeginStep(double dt);
  void AfterLaw(const LoadedLaw& law);
  /// Records the forces of a stage, after all laws have added their shares.
  void AfterForces(uint32_t stage);
  /// Records a whole step; called once per step, after the last stage.
  void AfterIntegrators();

  /// Discards the forces of the previous step, because the rows now stand for other bodies.
  void ForgetForces();

  /// Returns the line of a law that was passed to Plan. Columns must be current and laws bound.
  /// Throws the failure of a law when its potential energy is computed.
  LedgerLine Law(vesper_library_id library, uint32_t index) const;
  /// Returns the contribution of the client: applied forces, and changes between calls.
  const Balance& client() const { return client_.booked; }
  /// Returns the momentum that immovable bodies absorbed, with the opposite sign.
  const Balance& ground() const { return ground_.booked; }
  /// Returns the sum of the contributions of unloaded laws.
  const Balance& unloaded() const { return unloaded_; }
  /// Returns the measured change of all bodies from the beginning of the first advance to the end
  /// of the last advance. It equals the sum of all lines. Requirements and failures are those of
  /// Law.
  LedgerLine Total() const;

 private:
  /// Forces or torques of one account, collected over the stages of a step.
  struct Push {
    uint32_t use = kNone;         // index of the law's use that adds to the sum
    std::vector<double> impulse;  // (bodies x 3), force times time
    std::vector<double> last;     // (bodies x 3), from the last stage of the previous step
    Vector last_moment, last_ground_moment;
    double last_turning = 0;  // sum of the magnitudes of all moments
    bool has_last = false;
  };
  struct Account {
    vesper_library_id library = VESPER_NO_LIBRARY;
    uint32_t index = 0;
    LoadedLaw* law = nullptr;  // null: the account of the client or the ground
    bool moves = false;        // true if the law writes properties on which the totals depend
    std::array<Push, 2> pushes;
    Balance booked, pending;
    ImpulseSizes booked_sizes, pending_sizes;
    std::optional<double> initial_potential;  // [J], when the ledger first read the law's arrays
  };
  /// The property that sums forces, with the velocity that they change; or the property that sums
  /// torques, with the angular velocity.
  struct Channel {
    uint32_t sum, rate;              // indices of the two properties, or kNone
    Account* integrator = nullptr;   // account of the law that writes `rate`
    std::vector<double> begin = {};  // (bodies x 3), `rate` at the start of the step
  };

  std::shared_ptr<Account> Find(vesper_library_id library, uint32_t index) const;
  std::shared_ptr<Account> Open(vesper_library_id library, LoadedLaw& law) const;
  void FindIntegrators();
  static double PotentialEnergy(const Account& account);
  /// Visits all accounts that can exert forces: the client and the laws.
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
  std::vector<std::shared_ptr<Account>> laws_;  // accounts in load order
  Account client_;
  Account ground_;
  Balance unloaded_;
  std::array<Channel, 2> channels_;
  Balance total_;          // balance of all bodies after the law that ran last
  Balance booked_total_;   // balance of all bodies at the end of the last committed advance
  Balance opening_total_;  // balance of all bodies at the beginning of the first advance
  bool opened_ = false;    // true once the two totals above are set
  bool advancing_ = false;
  double dt_ = 0;  // [s]
};

}  // namespace vesper
