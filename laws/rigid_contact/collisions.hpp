// SPDX-License-Identifier: Apache-2.0
// Contact points of all pairs of shapes.
#pragma once

#include <cstdint>
#include <vector>

#include "broad_phase.hpp"
#include "manifold.hpp"
#include "vesper/law.hpp"

namespace vesper::rigid {

/** The contact points of pairs of shapes, of which one may be a surface. */
class Collisions {
 public:
  using Pairs = std::vector<Pair>;
  /** The surface of each shape, or null for shapes without a surface. Empty if there are no
   *  surfaces. */
  using Surfaces = std::vector<const Surface*>;

  /** Finds the contact points of the pairs that may meet, up to a separation of margin(pair). */
  template <class MayMeet, class Margin>
  void Find(const Step& step, const Pairs& pairs, const std::vector<Shape>& shapes,
            const Surfaces& surfaces, MayMeet&& may_meet, Margin&& margin) {
    manifolds_.resize(pairs.size());
    surface_pairs_.clear();
    step.ParallelFor(pairs.size(), kPairGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t i = begin; i < end; ++i) {
        const Pair pair = pairs[i];
        if (may_meet(pair) && !HasSurface(pair, surfaces)) {
          manifolds_[i] = Collide(shapes[pair.a], shapes[pair.b], margin(pair));
        } else {
          manifolds_[i].count = 0;
        }
      }
    });
    if (surfaces.empty()) return;
    for (size_t i = 0; i < pairs.size(); ++i) {
      if (HasSurface(pairs[i], surfaces) && may_meet(pairs[i])) surface_pairs_.push_back(i);
    }
    if (on_surfaces_.size() < surface_pairs_.size()) on_surfaces_.resize(surface_pairs_.size());
    step.ParallelFor(surface_pairs_.size(), kSurfaceGrain, [&](uint64_t begin, uint64_t end) {
      for (uint64_t k = begin; k < end; ++k) {
        const Pair pair = pairs[surface_pairs_[k]];
        const bool first = surfaces[pair.a] != nullptr;
        const uint32_t surface = first ? pair.a : pair.b, other = first ? pair.b : pair.a;
        on_surfaces_[k].Find(*surfaces[surface], shapes[surface], shapes[other], margin(pair));
      }
    });
  }

  /** Calls action(pair, manifold) for all contacts that Find found, in the order of the pairs. */
  template <class Action>
  void ForEach(const Pairs& pairs, const Surfaces& surfaces, Action&& action) const {
    size_t next = 0;  // surface pair
    for (size_t i = 0; i < pairs.size(); ++i) {
      if (manifolds_[i].count > 0) action(pairs[i], manifolds_[i]);
      if (next == surface_pairs_.size() || surface_pairs_[next] != i) continue;
      for (Manifold manifold : on_surfaces_[next].manifolds()) {
        if (surfaces[pairs[i].a] == nullptr) manifold.normal = -manifold.normal;
        action(pairs[i], manifold);
      }
      ++next;
    }
  }

 private:
  // Numbers of pairs per chunk of a thread, for pairs without and with surfaces.
  static constexpr uint64_t kPairGrain = 64, kSurfaceGrain = 4;

  static bool HasSurface(const Pair& pair, const Surfaces& surfaces) {
    return !surfaces.empty() && (surfaces[pair.a] != nullptr || surfaces[pair.b] != nullptr);
  }

  std::vector<Manifold> manifolds_;           // one per pair
  std::vector<size_t> surface_pairs_;         // indices of pairs, ascending
  std::vector<SurfaceContacts> on_surfaces_;  // one per surface pair
};

}  // namespace vesper::rigid
