// SPDX-License-Identifier: Apache-2.0
// Forces of bodies and of whole cells on a group of bodies, in SIMD.
#pragma once

#include <cstdint>
#include <vector>

#include "vesper/law.hpp"

namespace vesper::barnes_hut {

/// Bodies that walk the tree together. A multiple of the widest vector that is used.
inline constexpr uint32_t kGroup = 64;

/// Everything here is in the units of the tree, see Scales.

/// The least softening squared: bodies at one place then pull with 0, not with 0 times infinity.
template <class Real>
inline constexpr Real kLeastSoftening2 = sizeof(Real) == 4 ? Real(0x1p-82) : Real(0x1p-600);

/// A body as a source of force.
template <class Real>
struct Source {
  Vec3<Real> position;
  Real mass;
};

/// A cell as a source of force: its mass, and how it is spread about its centre.
template <class Real>
struct Multipole {
  Vec3<Real> centre;  // of mass
  Real mass;
  Real xx, xy, xz, yy, yz, zz;  // 3 sum m_i x_i x_j / mass, x from the centre
  Real trace;                   // xx + yy + zz
};

/// Sources [first, first + count), neighbours in the sorted order.
struct Run {
  uint32_t first, count;
};

/// A group of bodies and the sums over the sources met so far.
template <class Real>
struct Targets {
  alignas(64) Real x[kGroup], y[kGroup], z[kGroup];
  alignas(64) Real ax[kGroup], ay[kGroup], az[kGroup];  // sums of m d / r^3
};

/// The inner loops for one instruction set. Each target has a lane of its own and sums in the order
/// of the lists, with the same operations in every set: so all of them give the same bits.
template <class Real>
struct Interactions {
  const char* instruction_set;
  /// Adds the attraction of bodies, softened after Plummer: m d / (d^2 + softening2)^(3/2).
  /// softening2 is kLeastSoftening2 or more.
  void (*add_bodies)(Targets<Real>&, const Source<Real>* sources, const Run* runs, uint32_t count,
                     Real softening2);
  /// Adds the attraction of cells to second order in their size.
  void (*add_cells)(Targets<Real>&, const Multipole<Real>* cells, const uint32_t* list,
                    uint32_t count, Real softening2);
};

/// Those that this processor can run, the fastest first. Never empty.
template <class Real>
std::vector<Interactions<Real>> AvailableInteractions();

}  // namespace vesper::barnes_hut
