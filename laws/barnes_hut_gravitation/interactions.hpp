// SPDX-License-Identifier: Apache-2.0
// Forces of bodies and of whole cells on a group of bodies, computed with vector instructions.
#pragma once

#include <cstdint>
#include <vector>

#include "vesper/law.hpp"

namespace vesper::barnes_hut {

/// Bodies that traverse the tree together; a multiple of the widest vector used.
inline constexpr uint32_t kGroup = 64;

// All values in the rest of this file are in the units of the tree, see Scales.

/// Minimum of the squared softening. With it, two bodies at the same place attract each other with
/// the force 0. Without it, the force would be 0 times infinity.
template <class Real>
inline constexpr Real kLeastSoftening2 = sizeof(Real) == 4 ? Real(0x1p-82) : Real(0x1p-600);

/// A body as a source of force.
template <class Real>
struct Source {
  Vec3<Real> position;
  Real mass;
};

/// A cell as a source of force: its mass, and the second moments of the mass about its centre.
template <class Real>
struct Multipole {
  Vec3<Real> centre;  // centre of mass
  Real mass;
  Real xx, xy, xz, yy, yz, zz;  // 3 sum m_i x_i x_j / mass of the cell; x relative to the centre
  Real trace;                   // xx + yy + zz
};

/// Sources [first, first + count), adjacent in the order along the Hilbert curve.
struct Run {
  uint32_t first, count;
};

/// A group of bodies with their sums over the sources processed so far.
template <class Real>
struct Targets {
  alignas(64) Real x[kGroup], y[kGroup], z[kGroup];
  alignas(64) Real ax[kGroup], ay[kGroup], az[kGroup];  // sums of m d / r^3
};

/// The inner loops for one instruction set. Each target body has its own lane, which adds sources
/// in the order of the lists. Every set uses the same operations, so all give the same bits.
template <class Real>
struct Interactions {
  const char* instruction_set;
  /// Adds the attraction of bodies with Plummer softening: m d / (d^2 + softening2)^(3/2).
  /// softening2 must be at least kLeastSoftening2.
  void (*add_bodies)(Targets<Real>&, const Source<Real>* sources, const Run* runs, uint32_t count,
                     Real softening2);
  /// Adds the attraction of cells, to second order in the cells' size.
  void (*add_cells)(Targets<Real>&, const Multipole<Real>* cells, const uint32_t* list,
                    uint32_t count, Real softening2);
};

/// Returns the loops that this processor supports, the fastest first. Never empty.
template <class Real>
std::vector<Interactions<Real>> AvailableInteractions();

}  // namespace vesper::barnes_hut
