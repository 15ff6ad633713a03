// SPDX-License-Identifier: Apache-2.0
// Highway includes this file once for each instruction set. This file also selects the version that
// runs. Highway's own selection is in a shared library, and a law must not need a shared library.
#include "all_pairs/pair_sums.hpp"

#include <algorithm>
#include <cmath>

// On x86 the remaining targets are the baseline (one lane), AVX2 with FMA, and AVX-512. Targets
// with vectors of unknown length are disabled, because such vectors do not match the packets.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "all_pairs/pair_sums.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"

#include "all_pairs/inverse_cube-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace vesper {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The rows of a group share the loaded columns.
constexpr uint64_t kGroup = 4;

/// A part of the lanes of the sums of a group. It is in registers.
template <class V>
struct GroupSums {
  V x[kGroup], y[kGroup], z[kGroup];
};

/// Adds the forces between the bodies [row, row + kGroup) of one packet and a vector of bodies,
/// from `lane` on, of a later packet or of the same packet. Each pair within one packet occurs in
/// both orders. Therefore only the rows get sums in this case (`both` is false).
template <class Root, bool both, class Real, class D, class V = hn::Vec<D>>
HWY_INLINE void SumBlock(D d, const BodyPacket<Real>& rows, uint64_t row,
                         const BodyPacket<Real>& columns, uint64_t lane, V softening2,
                         GroupSums<V>& group, SumPacket<Real>* sums) {
  const V x = hn::Load(d, columns.x + lane), y = hn::Load(d, columns.y + lane),
          z = hn::Load(d, columns.z + lane), weight = hn::Load(d, columns.weight + lane);
  V sx = hn::Zero(d), sy = sx, sz = sx;
  if constexpr (both) {
    sx = hn::Load(d, sums->x + lane);
    sy = hn::Load(d, sums->y + lane);
    sz = hn::Load(d, sums->z + lane);
  }
#pragma GCC unroll 8
  for (uint64_t u = 0; u < kGroup; ++u) {
    const V dx = hn::Sub(x, hn::Set(d, rows.x[row + u]));
    const V dy = hn::Sub(y, hn::Set(d, rows.y[row + u]));
    const V dz = hn::Sub(z, hn::Set(d, rows.z[row + u]));
    const V r2 = Fused(d, dx, dx, Fused(d, dy, dy, Fused(d, dz, dz, softening2)));
    const V strength =
        hn::Mul(Root::InverseCube(d, r2), hn::Mul(weight, hn::Set(d, rows.weight[row + u])));
    const V fx = hn::Mul(strength, dx), fy = hn::Mul(strength, dy), fz = hn::Mul(strength, dz);
    group.x[u] = hn::Add(group.x[u], fx);
    group.y[u] = hn::Add(group.y[u], fy);
    group.z[u] = hn::Add(group.z[u], fz);
    if constexpr (both) {
      sx = hn::Sub(sx, fx);
      sy = hn::Sub(sy, fy);
      sz = hn::Sub(sz, fz);
    }
  }
  if constexpr (both) {
    hn::Store(sx, d, sums->x + lane);
    hn::Store(sy, d, sums->y + lane);
    hn::Store(sz, d, sums->z + lane);
  }
}

/// Returns the sum of the lanes of a vector, by halves.
template <class D, class V = hn::Vec<D>>
HWY_INLINE hn::TFromD<D> FoldLanes(D d, V v) {
  if constexpr (hn::MaxLanes(d) == 1) {
    return hn::GetLane(v);
  } else {
    const hn::Half<D> half;
    // UpperHalf has no namespace, so that the compiler searches it only when the function is
    // instantiated. Highway has no UpperHalf for vectors with one lane.
    return FoldLanes(half, hn::Add(hn::LowerHalf(half, v), UpperHalf(half, v)));
  }
}

/// Returns the sum of the lanes of a packet, by halves.
template <class Real>
HWY_INLINE Real SumOfPacket(const Real* lanes) {
  const hn::CappedTag<Real, BodyPacket<Real>::kSize> d;
  constexpr uint64_t kVectors = BodyPacket<Real>::kSize / hn::MaxLanes(d);
  hn::Vec<decltype(d)> sum[kVectors];
  for (uint64_t i = 0; i < kVectors; ++i) sum[i] = hn::Load(d, lanes + i * hn::MaxLanes(d));
  for (uint64_t half = kVectors / 2; half > 0; half /= 2) {
    for (uint64_t i = 0; i < half; ++i) sum[i] = hn::Add(sum[i], sum[i + half]);
  }
  return FoldLanes(d, sum[0]);
}

/// Adds the forces between the bodies [row, row + kGroup) of packet p and the bodies of the packets
/// [begin, end). If p is in this range, it is the first packet of the range.
template <class Root, class Real>
HWY_INLINE void SumGroup(const BodyPacket<Real>* bodies, uint64_t p, uint64_t row, uint64_t begin,
                         uint64_t end, Real softening, SumPacket<Real>* sums) {
  constexpr uint64_t kSize = BodyPacket<Real>::kSize;
  const hn::CappedTag<Real, kSize> d;
  using V = hn::Vec<decltype(d)>;
  const V softening2 = hn::Set(d, softening);
  HWY_ALIGN Real lanes[3][kGroup][kSize];
  for (uint64_t lane = 0; lane < kSize; lane += hn::MaxLanes(d)) {
    GroupSums<V> group;
#pragma GCC unroll 8
    for (uint64_t u = 0; u < kGroup; ++u) group.x[u] = group.y[u] = group.z[u] = hn::Zero(d);
    uint64_t q = begin;
    if (q == p) {
      SumBlock<Root, false, Real>(d, bodies[p], row, bodies[p], lane, softening2, group, nullptr);
      ++q;
    }
    for (; q < end; ++q) {
      SumBlock<Root, true, Real>(d, bodies[p], row, bodies[q], lane, softening2, group, sums + q);
    }
#pragma GCC unroll 8
    for (uint64_t u = 0; u < kGroup; ++u) {
      hn::Store(group.x[u], d, lanes[0][u] + lane);
      hn::Store(group.y[u], d, lanes[1][u] + lane);
      hn::Store(group.z[u], d, lanes[2][u] + lane);
    }
  }
  for (uint64_t u = 0; u < kGroup; ++u) {
    sums[p].x[row + u] += SumOfPacket(lanes[0][u]);
    sums[p].y[row + u] += SumOfPacket(lanes[1][u]);
    sums[p].z[row + u] += SumOfPacket(lanes[2][u]);
  }
}

// Number of packets of columns that stay in the first-level cache while the rows are processed.
constexpr uint64_t kTile = 64;

template <class Root, class Real>
HWY_INLINE void SumTiles(const BodyPacket<Real>* bodies, uint64_t rows, uint64_t count,
                         Real softening2, SumPacket<Real>* sums) {
  for (uint64_t begin = 0; begin < count; begin += kTile) {
    const uint64_t end = std::min(begin + kTile, count);
    for (uint64_t p = 0; p < std::min(rows, end); ++p) {
      for (uint64_t row = 0; row < BodyPacket<Real>::kSize; row += kGroup) {
        SumGroup<Root>(bodies, p, row, std::max(begin, p), end, softening2, sums);
      }
    }
  }
}

template <class Real>
void SumPairs(ReciprocalRoot root, const BodyPacket<Real>* bodies, uint64_t rows, uint64_t count,
              Real softening2, SumPacket<Real>* sums) {
  if (root == ReciprocalRoot::kApproximate) {
    SumTiles<ApproximateRoot>(bodies, rows, count, softening2, sums);
  } else {
    SumTiles<PortableRoot>(bodies, rows, count, softening2, sums);
  }
}

/// Returns the sum over the pairs of one body of packet p with each body after it.
HWY_INLINE double SumPotentialsOf(const BodyPacket<double>* bodies, uint64_t p, uint64_t row,
                                  uint64_t count, double softening2) {
  constexpr uint64_t kSize = BodyPacket<double>::kSize;
  const hn::CappedTag<double, kSize> d;
  const BodyPacket<double>& own = bodies[p];
  HWY_ALIGN double lanes[kSize];
  for (uint64_t lane = 0; lane < kSize; lane += hn::MaxLanes(d)) {
    auto sum = hn::Zero(d);
    for (uint64_t q = p; q < count; ++q) {
      const auto dx = hn::Sub(hn::Load(d, bodies[q].x + lane), hn::Set(d, own.x[row]));
      const auto dy = hn::Sub(hn::Load(d, bodies[q].y + lane), hn::Set(d, own.y[row]));
      const auto dz = hn::Sub(hn::Load(d, bodies[q].z + lane), hn::Set(d, own.z[row]));
      const auto r2 = Fused(d, dx, dx, Fused(d, dy, dy, Fused(d, dz, dz, hn::Set(d, softening2))));
      const auto potential = hn::Div(hn::Load(d, bodies[q].weight + lane), hn::Sqrt(r2));
      // A body is paired only with the bodies after it in its own packet.
      const auto first = hn::Set(d, q == p ? static_cast<double>(row + 1) : 0.0);
      const auto none =
          hn::Or(hn::Lt(hn::Iota(d, static_cast<double>(lane)), first), hn::Eq(r2, hn::Zero(d)));
      sum = hn::Add(sum, hn::IfThenZeroElse(none, potential));
    }
    hn::Store(sum, d, lanes + lane);
  }
  return own.weight[row] * SumOfPacket(lanes);
}

double SumPotentials(const BodyPacket<double>* bodies, uint64_t count, double softening2) {
  double sum = 0;
  for (uint64_t p = 0; p < count; ++p) {
    for (uint64_t row = 0; row < BodyPacket<double>::kSize; ++row) {
      sum += SumPotentialsOf(bodies, p, row, count, softening2);
    }
  }
  return sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace vesper
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vesper {

// Calls the function that was compiled for this instruction set.
#if HWY_ARCH_X86_64
#define VESPER_DISPATCH(set, function)                 \
  ((set) == InstructionSet::kAvx512 ? N_AVX3::function \
   : (set) == InstructionSet::kAvx2 ? N_AVX2::function \
                                    : HWY_STATIC_DISPATCH(function))
#else
#define VESPER_DISPATCH(set, function) HWY_STATIC_DISPATCH(function)
#endif

template <class Real>
void SumPairs(InstructionSet set, ReciprocalRoot root, const BodyPacket<Real>* bodies,
              uint64_t rows, uint64_t count, Real softening2, SumPacket<Real>* sums) {
  VESPER_DISPATCH(set, SumPairs<Real>)(root, bodies, rows, count, softening2, sums);
}

template void SumPairs(InstructionSet, ReciprocalRoot, const BodyPacket<float>*, uint64_t, uint64_t,
                       float, SumPacket<float>*);
template void SumPairs(InstructionSet, ReciprocalRoot, const BodyPacket<double>*, uint64_t,
                       uint64_t, double, SumPacket<double>*);

double SumPotentials(InstructionSet set, const BodyPacket<double>* bodies, uint64_t count,
                     double softening2) {
  return VESPER_DISPATCH(set, SumPotentials)(bodies, count, softening2);
}

}  // namespace vesper
#endif  // HWY_ONCE
