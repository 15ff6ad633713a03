// SPDX-License-Identifier: Apache-2.0
// Tracking of stale arrays, whose newest values are in a law's own memory.
#pragma once

#include <cstdint>
#include <vector>

#include "columns.hpp"
#include "phase_laws.hpp"

namespace vesper {

/// Tracks arrays that are stale because a law deferred its writes. A law holds a property if it was
/// the last to write it through a DEFERRED use. The hold ends when `synchronize` of that law has
/// written the array, or when the client declares the array valid by touch or rebind.
///
/// A library with DEFERRED uses of a property has a copy, made from the array at a version. Any
/// write to the array by another party raises the version that such uses see, but never while the
/// property is held. Therefore a new version means that the array is valid, and an unchanged
/// version means that the copy is valid. Not thread-safe.
class DeferredWrites {
 public:
  explicit DeferredWrites(Columns& columns) : columns_(columns), properties_(columns.size()) {}

  /// Updates the set of laws. Holders that remain keep their holds.
  void Plan(const std::vector<ScheduledLaw>& laws);
  /// Returns true if no law defers a write.
  bool none() const { return none_; }
  /// Returns the version that a use of the property sees.
  uint64_t Version(uint32_t property, const vesper_property_use& use) const;

  /// Synchronizes the arrays that the law reads, except those that its own library holds.
  void Before(const ScheduledLaw& law, uint32_t stage);
  /// Records what the law wrote or deferred.
  void After(const ScheduledLaw& law);
  /// Records that the whole array was written, or that no law held it.
  void Written(uint32_t property);

  /// Writes the array if it is held. On failure throws with the law that holds it as the cause.
  void Synchronize(uint32_t property, uint32_t stage = 0);
  void SynchronizeAll(uint32_t stage = 0);
  void SynchronizeHeldBy(const LawLibrary& library);
  /// Ends all holds: the arrays are valid from now on.
  void TakeArrays();

 private:
  struct State {
    const LawLibrary* user = nullptr;  // library whose laws defer their use of it; null for none
    bool several_users = false;
    ScheduledLaw holder{};  // no law: the array is fresh
    uint32_t use = 0;       // index in the holder's uses
    uint64_t held_at = 0;   // column version at the deferred write; a different version ends the
                            // hold
    uint64_t writes = 0;    // number of writes to the array, except those by the client
  };

  bool IsHeld(uint32_t property) const;
  /// Makes the law that holds the property write the array.
  void Fetch(uint32_t property, uint32_t stage);
  /// Fetches the inputs of `law` that other laws hold. A value that is not finite may have come
  /// from there; then the holder is the cause.
  void FetchInputs(const ScheduledLaw& law, uint32_t stage);

  Columns& columns_;
  std::vector<State> properties_;  // in prototype order
  bool none_ = true;
};

}  // namespace vesper
