// SPDX-License-Identifier: Apache-2.0
// Tracking of stale arrays. An array is stale if its newest values are only in a law's own memory,
// such as the memory of a GPU.
#pragma once

#include <cstdint>
#include <vector>

#include "columns.hpp"
#include "phase_laws.hpp"

namespace vesper {

/// Tracks arrays that are stale because a law deferred its writes. A law *holds* a property if it
/// was the last writer of the property, through a DEFERRED use. The hold ends when the law's
/// `synchronize` has written the array. It also ends when the client declares the array valid by
/// touch or rebind.
///
/// A library with DEFERRED uses of a property has a copy of the array, which it made at some
/// version of the property. Any write to the array by others increases the version that these uses
/// receive, but not while a law holds the property. Therefore a new version means that the array is
/// valid, and an unchanged version means that the copy is valid. Not thread-safe.
class DeferredWrites {
 public:
  explicit DeferredWrites(Columns& columns) : columns_(columns), properties_(columns.size()) {}

  /// Updates the set of laws. Laws that stay loaded keep their holds.
  void Plan(const std::vector<ScheduledLaw>& laws);
  /// Returns true if no law defers a write.
  bool none() const { return none_; }
  /// Returns the version that a use of the property receives in `bind`.
  uint64_t Version(uint32_t property, const vesper_property_use& use) const;

  /// Synchronizes the arrays that the law reads, except those that its own library holds. Must be
  /// called before the law runs.
  void Before(const ScheduledLaw& law, uint32_t stage);
  /// Records which properties the law wrote or deferred. Must be called after the law has run.
  void After(const ScheduledLaw& law);
  /// Records that the engine or the client has written the whole array, so that no law holds it.
  void Written(uint32_t property);

  /// If a law holds the property, makes it write the array. On failure throws, naming that law.
  void Synchronize(uint32_t property, uint32_t stage = 0);
  void SynchronizeAll(uint32_t stage = 0);
  void SynchronizeHeldBy(const LawLibrary& library);
  /// Ends all holds: the arrays count as valid from now on.
  void TakeArrays();

 private:
  struct State {
    const LawLibrary* user = nullptr;  // library with DEFERRED uses of the property; null if there
                                       // is none
    bool several_users = false;
    ScheduledLaw holder{};  // the law that holds the property; empty: the array is valid
    uint32_t use = 0;       // index in the holder's uses
    uint64_t held_at = 0;   // column version at the deferred write; a different version ends the
                            // hold
    uint64_t writes = 0;    // number of writes to the array, except those by the client
  };

  bool IsHeld(uint32_t property) const;
  /// Makes the law that holds the property write the array, by `synchronize`.
  void Fetch(uint32_t property, uint32_t stage);
  /// Fetches the inputs of `law` that other laws hold. If a fetched value is not finite, the
  /// failure names the holder.
  void FetchInputs(const ScheduledLaw& law, uint32_t stage);

  Columns& columns_;
  std::vector<State> properties_;  // states in prototype order
  bool none_ = true;
};

}  // namespace vesper
