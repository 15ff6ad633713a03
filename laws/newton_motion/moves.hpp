// SPDX-License-Identifier: Apache-2.0
// A step of semi-implicit Euler, compiled for several instruction sets with the same bits.
#pragma once

#include <cstdint>
#include <vector>

#include "vesper/law.hpp"

namespace vesper::newton_motion {

/// The columns of the moving bodies.
template <class Real>
struct Bodies {
  const Real* mass;         // [kg]
  const Vec3<Real>* force;  // [N]
  Vec3<Real>* velocity;     // [m/s]
  Vec3<Real>* position;     // [m]
};

/// The function for one instruction set.
template <class Real>
struct Moves {
  const char* instruction_set;
  /// Moves the bodies in the rows from `begin` up to `end`; bodies of mass 0 do not change at all.
  void (*move)(const Bodies<Real>& bodies, uint64_t begin, uint64_t end, Real dt);
};

/// Returns the functions that this processor supports, the fastest first.
template <class Real>
std::vector<Moves<Real>> AvailableMoves();

}  // namespace vesper::newton_motion
