// SPDX-License-Identifier: Apache-2.0
// The loops over pairs of bodies, compiled for several instruction sets with the same bits.
#pragma once

#include <cstdint>

#include "simd/instruction_set.hpp"

namespace vesper {

/// Bodies in a structure of arrays, with one cache line per quantity.
template <class Real>
struct alignas(64) BodyPacket {
  static constexpr uint64_t kSize = 64 / sizeof(Real);
  Real x[kSize], y[kSize], z[kSize], weight[kSize];
};

/// Sums of the bodies of a packet.
template <class Real>
struct alignas(64) SumPacket {
  static constexpr uint64_t kSize = 64 / sizeof(Real);
  Real x[kSize], y[kSize], z[kSize];
};

/// Method to compute 1/r of a pair.
enum class ReciprocalRoot {
  kPortable,     ///< by arithmetic that gives the same bits on every processor
  kApproximate,  ///< from the processor's approximation, corrected: as accurate and faster, but the
                 ///< bits depend on the processor
};

/** Computes all pairs of bodies of which at least one is in the first `rows` of `count` packets.
 *  Adds to the sums of each body i
 *
 *      sum over j of weight_i weight_j (x_j - x_i) / (|x_j - x_i|^2 + softening2)^(3/2)
 *
 *  with an error of a few roundings. `softening2` must be above 0, and its power -3/2 times two
 *  weights must be finite, because softening2 is the whole denominator at distance 0. `sums` has
 *  `count` packets. */
template <class Real>
void SumPairs(InstructionSet set, ReciprocalRoot root, const BodyPacket<Real>* bodies,
              uint64_t rows, uint64_t count, Real softening2, SumPacket<Real>* sums);

/** Returns the sum over all pairs of weight_i weight_j / sqrt(|x_j - x_i|^2 + softening2). A
 *  pair with 0 under the root adds nothing. */
double SumPotentials(InstructionSet set, const BodyPacket<double>* bodies, uint64_t count,
                     double softening2);

}  // namespace vesper
