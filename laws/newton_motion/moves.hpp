// SPDX-License-Identifier: Apache-2.0
// A step of semi-implicit Euler, compiled for several instruction sets with the same bits.
#pragma once

#include <cstdint>
#include <vector>

#include "vesper/law.hpp"

namespace vesper::newton_motion {

/// The columns of the bodies that move.
template <class Real>
struct Bodies {
  const Real* mass;         // [kg]
  const Vec3<Real>* force;  // [N]
  Vec3<Real>* velocity;     // [m/s]
  Vec3<Real>* position;     // [m]
};

/// The function, compiled for one instruction set.
template <class Real>
struct Moves {
  const char* instruction_set;
  /// Moves the bodies in the rows from `begin` up to `end`; those of mass 0 keep their bits.
  void (*move)(const Bodies<Real>& bodies, uint64_t begin, uint64_t end, Real dt);
};

/// Those that this processor can run, the fastest first.
template <class Real>
std::vector<Moves<Real>> AvailableMoves();

}  // namespace vesper::newton_motion
