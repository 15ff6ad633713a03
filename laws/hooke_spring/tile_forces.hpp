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
  Real position[4];  // [m], three components
  Real velocity[4];  // [m/s], three components
};

/// Forces on the first ends of the springs of a batch [N], three components each.
template <class Real>
struct alignas(64) Forces {
  Real value[kBatch][4];
};

/// The springs of one part of a tile. The number of slots is rounded up to whole batches of kBatch,
/// at least one batch. SpringTiles describes how the ends of springs are stored.
template <class Real>
struct TileSprings {
  uint64_t count;
  const uint16_t *first_ends, *second_ends;
  /// (count), rows of the springs in the columns, and (count / kBatch), SpringTiles::first_rows;
  /// both are null if spring i has row i.
  const uint32_t *rows, *first_rows;
  const Real* length;   // [m]
  const Real* hooke;    // [N/m]
  const Real* damping;  // [N s/m]; null: undamped
};

/// The functions for one instruction set.
template <class Real>
struct TileForces {
  const char* instruction_set;
  /** Copies the motions of `count` bodies from columns of `bodies` rows. motions[i] becomes the
   *  motion of the body in row rows[i], or in row first + i if `rows` is null. */
  void (*take)(const Vec3<Real>* position, const Vec3<Real>* velocity, uint64_t bodies,
               const uint32_t* rows, uint64_t first, uint64_t count, Motion<Real>* motions);
  /// Computes the force of each spring on its first end; the force on the second end is opposite.
  void (*pull)(const TileSprings<Real>& springs, const Motion<Real>* motions, Forces<Real>* forces);
  /** Adds forces to the sums of `count` bodies. For each body, adds the forces of the slots that
   *  `pulls` lists for this body. `pulls` and `pull_counts` (count x 2) are those of
   *  SpringTiles. */
  void (*sum)(const Forces<Real>* forces, const uint16_t* pulls, const uint16_t* pull_counts,
              uint64_t count, Vec3<Real>* sums);
};

/// Returns the functions that this processor supports, the fastest first.
template <class Real>
std::vector<TileForces<Real>> AvailableTileForces();

}  // namespace vesper::hooke_spring
