// SPDX-License-Identifier: Apache-2.0
// The forces of the springs of a tile, compiled for several instruction sets with the same bits.
#pragma once

#include <cstdint>
#include <vector>

#include "spring_tiles.hpp"
#include "vesper/law.hpp"

namespace vesper::hooke_spring {

/// A body of a tile.
template <class Real>
struct alignas(8 * sizeof(Real)) Motion {
  Real position[4];  // [m], three of them
  Real velocity[4];  // [m/s], three of them
};

/// Forces on the first ends of the springs of a batch [N], three components each.
template <class Real>
struct alignas(64) Forces {
  Real value[kBatch][4];
};

/// Springs of a part, in slots: a multiple of kBatch, at least one. For the ends see SpringTiles.
template <class Real>
struct TileSprings {
  uint64_t count;
  const uint16_t *first_ends, *second_ends;
  /// (count), where in the columns the springs are, and (count / kBatch), first_rows; null if
  /// spring i has row i.
  const uint32_t *rows, *first_rows;
  const Real* length;   // [m]
  const Real* hooke;    // [N/m]
  const Real* damping;  // [N s/m]; null: undamped
};

/// The functions, compiled for one instruction set.
template <class Real>
struct TileForces {
  const char* instruction_set;
  /** motions[i] = those of the body in row rows[i], or of row first + i if rows is null; of columns
   *  of `bodies` rows. */
  void (*take)(const Vec3<Real>* position, const Vec3<Real>* velocity, uint64_t bodies,
               const uint32_t* rows, uint64_t first, uint64_t count, Motion<Real>* motions);
  /// What each spring exerts on its first end; the second feels the opposite.
  void (*pull)(const TileSprings<Real>& springs, const Motion<Real>* motions, Forces<Real>* forces);
  /** Adds to each of `count` bodies the forces that `pulls` names for it; pull_counts (count x 2):
   *  see SpringTiles. */
  void (*sum)(const Forces<Real>* forces, const uint16_t* pulls, const uint16_t* pull_counts,
              uint64_t count, Vec3<Real>* sums);
};

/// Those that this processor can run, the fastest first.
template <class Real>
std::vector<TileForces<Real>> AvailableTileForces();

}  // namespace vesper::hooke_spring
