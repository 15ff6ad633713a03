// SPDX-License-Identifier: Apache-2.0
// Arrays that are stale, because a law keeps the newest values in memory of its own.
#pragma once

#include <cstdint>
#include <vector>

#include "columns.hpp"
#include "phase_laws.hpp"

namespace vesper {

/// A property is held by the law that was the last to write it through a DEFERRED use, until
/// `synchronize` of that law has written the array, or until the client says that the array counts,
/// by touch or rebind.
///
/// A library whose laws use a property DEFERRED has a copy of it, taken from the array at a
/// version. Whenever somebody else wrote the array, the version that such uses see is raised, never
/// while the property is held: so a new version means that the array counts, and the same one that
/// the copy does. Not thread-safe.
class DeferredWrites {
 public:
  explicit DeferredWrites(Columns& columns) : columns_(columns), properties_(columns.size()) {}

  /// Takes over which laws there are. Holders among them go on holding.
  void Plan(const std::vector<ScheduledLaw>& laws);
  /// Whether no law defers anything.
  bool none() const { return none_; }
  /// What a use of the property sees as its version.
  uint64_t Version(uint32_t property, const vesper_property_use& use) const;

  /// Lets the law see fresh arrays, but for what it takes from its own library.
  void Before(const ScheduledLaw& law, uint32_t stage);
  /// Takes note of what the law wrote, or deferred.
  void After(const ScheduledLaw& law);
  /// Somebody wrote the whole array, or it was held by nobody.
  void Written(uint32_t property);

  /// Makes the array fresh. Throws what is wrong, laid at the door of the law that holds it.
  void Synchronize(uint32_t property, uint32_t stage = 0);
  void SynchronizeAll(uint32_t stage = 0);
  void SynchronizeHeldBy(const LawLibrary& library);
  /// From here on the arrays count, whatever laws hold.
  void TakeArrays();

 private:
  struct State {
    const LawLibrary* user = nullptr;  // whose laws defer their use of it; null for none
    bool several_users = false;
    ScheduledLaw holder{};  // no law: the array is fresh
    uint32_t use = 0;       // place in the holder's uses
    uint64_t held_at = 0;   // version of the column; another one, and the hold is off
    uint64_t writes = 0;    // of the array, by anybody but the client
  };

  bool IsHeld(uint32_t property) const;
  /// Has the law that holds the property write the array.
  void Fetch(uint32_t property, uint32_t stage);
  /// The same of what other laws hold of what the law uses: what is wrong in its results may have
  /// come from there, and then they are to blame.
  void FetchInputs(const ScheduledLaw& law, uint32_t stage);

  Columns& columns_;
  std::vector<State> properties_;  // in prototype order
  bool none_ = true;
};

}  // namespace vesper
