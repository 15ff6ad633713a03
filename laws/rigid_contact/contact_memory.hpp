// SPDX-License-Identifier: Apache-2.0
// Contact impulses of the last step, in scratch columns of the engine.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "solver.hpp"

namespace vesper::rigid {

/** Maximum number of contacts that a body stores: its contacts with larger bodies and with
 *  immovable shapes. */
constexpr uint32_t kSlots = 8;

/** Scratch column of a body: for each contact, the name of the other shape plus 1; 0 if there is
 *  no contact. */
using SlotPartners = std::array<uint32_t, kSlots>;
/** Returns the name of a shape: the row of a body, or a number counted down from the largest one
 * for scenery, so that the names of scenery do not change if bodies are added. */
inline uint32_t NameOf(uint32_t shape, uint64_t bodies) {
  return shape < bodies ? shape : UINT32_MAX - 1 - (shape - uint32_t(bodies));
}
/** Scratch column of a body: a vector for each point of each contact; 0 if there is no such point.
 *  */
template <class Real>
using SlotVectors = std::array<Real, kSlots * Manifold::kMost * 3>;

/** The contacts of a body in the last step: the positions of their points relative to its centre
 *  [m], and the impulses on the other body [N s], in world axes. */
template <class Real>
struct ContactMemory {
  SlotPartners& partners;
  SlotVectors<Real>& places;
  SlotVectors<Real>& impulses;
  bool is_first;  // the body is the first one of the contact

  /** Matches each point of a contact with the nearest point of the last step within `reach` [m].
   *  Takes over the impulses and the order of the old points. With another order, the impulses
   *  would differ slightly in each step, and resting bodies would not come to rest. Two shapes may
   *  have several contacts with different directions. */
  void Recall(Contact<Real>& contact, uint32_t partner, Real reach) const {
    std::array<uint32_t, kSlots> slots;  // slots with this partner
    uint32_t known = 0;
    for (uint32_t slot = 0; slot < kSlots; ++slot) {
      if (partners[slot] == partner + 1) slots[known++] = slot;
    }
    if (known == 0) return;
    uint32_t taken = 0;
    std::array<int, Manifold::kMost> place;  // index of the matching point of the last step
    for (int i = 0; i < contact.count; ++i) {
      auto& point = contact.points[i];
      const Vec3<Real> arm = is_first ? point.arm_a : point.arm_b;
      Real nearest = reach * reach;
      place[i] = kPlaces;
      for (uint32_t k = 0; k < known; ++k) {
        for (uint32_t j = slots[k] * Manifold::kMost; j < (slots[k] + 1) * Manifold::kMost; ++j) {
          const Vec3<Real> way = Get(places, j) - arm;
          const Real square = Dot(way, way);
          if ((taken & (1u << j)) != 0 || !(square < nearest)) continue;
          if (known > 1 && !IsAlong(Get(impulses, j) * sign(), contact.normal)) continue;
          nearest = square;
          place[i] = int(j);
        }
      }
      if (place[i] == kPlaces) continue;
      taken |= 1u << place[i];
      const Vec3<Real> impulse = Get(impulses, uint32_t(place[i])) * sign();
      point.press = std::max(Real(0), Dot(impulse, contact.normal));
      point.rub[0] = Dot(impulse, contact.across[0]);
      point.rub[1] = Dot(impulse, contact.across[1]);
    }
    for (int i = 1; i < contact.count; ++i) {  // sorts by place; new points keep their order
      for (int k = i; k > 0 && place[k] < place[k - 1]; --k) {
        std::swap(contact.points[k], contact.points[k - 1]);
        std::swap(place[k], place[k - 1]);
      }
    }
  }

  /** Stores a contact in the next free slot; drops it if all are used. */
  void Store(const Contact<Real>& contact, uint32_t partner, uint32_t& used) const {
    if (used == kSlots) return;
    partners[used] = partner + 1;
    for (int i = 0; i < Manifold::kMost; ++i) {
      const uint32_t slot = used * Manifold::kMost + static_cast<uint32_t>(i);
      const bool exists = i < contact.count;
      const auto& point = contact.points[exists ? i : 0];
      Set(places, slot, exists ? (is_first ? point.arm_a : point.arm_b) : Vec3<Real>{});
      Set(impulses, slot, exists ? contact.Impulse(point) * sign() : Vec3<Real>{});
    }
    ++used;
  }

  /** Returns the impulse on the other body of the contact in a slot, at all points [N s]. */
  static Vec3<Real> ImpulseOf(const SlotVectors<Real>& impulses, uint32_t slot) {
    Vec3<Real> sum;
    for (uint32_t i = 0; i < Manifold::kMost; ++i) sum += Get(impulses, slot * Manifold::kMost + i);
    return sum;
  }

 private:
  static constexpr int kPlaces = int(kSlots) * Manifold::kMost;
  static_assert(kPlaces <= 32, "`taken` has a bit for each place");

  /** Returns whether an impulse can come from a contact with this normal: the angle between them is
   *  at most 60 degrees. */
  static bool IsAlong(const Vec3<Real>& impulse, const Vec3<Real>& normal) {
    const Real along = Dot(impulse, normal);
    return along >= 0 && along * along >= Real(0.25) * Dot(impulse, impulse);
  }
  Real sign() const { return is_first ? Real(1) : Real(-1); }
  static Vec3<Real> Get(const SlotVectors<Real>& from, uint32_t slot) {
    return {from[3 * slot], from[3 * slot + 1], from[3 * slot + 2]};
  }
  static void Set(SlotVectors<Real>& into, uint32_t slot, const Vec3<Real>& vector) {
    into[3 * slot] = vector.x;
    into[3 * slot + 1] = vector.y;
    into[3 * slot + 2] = vector.z;
  }
};

}  // namespace vesper::rigid
