// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tile_forces.cpp"
// The targets are AVX2, AVX-512 and the baseline of the processor family.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>

#include "simd/instruction_set.hpp"
#include "tile_forces.hpp"

HWY_BEFORE_NAMESPACE();
namespace vesper::hooke_spring::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Prefetch distance [bytes]. The code prefetches data itself, because the processor's prefetch
// stops at the end of each page.
constexpr uint64_t kAhead = 1024;

/// Prefetches `count` values beyond the current position.
template <class T>
HWY_INLINE void AskAhead(const T* values, uint64_t count) {
  for (uint64_t byte = 0; byte < count * sizeof(T); byte += 64) {
    __builtin_prefetch(reinterpret_cast<const char*>(values) + kAhead + byte);
  }
}

#if HWY_MAX_BYTES >= 32
/// Type of vectors of 256 bits. Such a vector contains one body in float, or half a body in double.
template <class Real>
using Lanes = hn::CappedTag<Real, 32 / sizeof(Real)>;
#else  // vectors too short for a body
template <class Real>
using Lanes = hn::CappedTag<Real, 1>;
#endif
template <class Real>
using V = hn::Vec<Lanes<Real>>;

/// The three components of a vector, for one spring per lane.
template <class Real>
struct Axes {
  V<Real> x, y, z;
};

/// Difference from the first to the second end of each spring, in position and velocity.
template <class Real>
struct Stretch {
  Axes<Real> way, speed;  // [m], [m/s]
};

#if HWY_MAX_BYTES >= 32

/// The three components of a body's position or velocity, and an unused fourth number.
template <class Real>
using Four = hn::CappedTag<Real, 4>;

/// Transposes four rows to columns. A row has three numbers and an unused fourth number. Each half
/// of the vectors is transposed separately.
HWY_INLINE Axes<float> Transpose(V<float> a, V<float> b, V<float> c, V<float> d) {
  const Lanes<float> l;
  const auto ac = hn::InterleaveLower(l, a, c), bd = hn::InterleaveLower(l, b, d);
  return {hn::InterleaveLower(l, ac, bd), hn::InterleaveUpper(l, ac, bd),
          hn::InterleaveLower(l, hn::InterleaveUpper(l, a, c), hn::InterleaveUpper(l, b, d))};
}
HWY_INLINE Axes<double> Transpose(V<double> a, V<double> b, V<double> c, V<double> d) {
  const Lanes<double> l;
  const auto ab = hn::InterleaveLower(l, a, b), cd = hn::InterleaveLower(l, c, d);
  return {hn::ConcatLowerLower(l, cd, ab),
          hn::ConcatLowerLower(l, hn::InterleaveUpper(l, c, d), hn::InterleaveUpper(l, a, b)),
          hn::ConcatUpperUpper(l, cd, ab)};
}

/// Returns the second end minus the first end, for positions or velocities.
template <class Real>
HWY_INLINE V<Real> Difference(const Real* values, uint16_t first, uint16_t second) {
  constexpr uint64_t kStride = sizeof(Motion<Real>) / sizeof(Real);
  const Lanes<Real> l;
  return hn::Sub(hn::Load(l, values + kStride * second), hn::Load(l, values + kStride * first));
}

/// Computes the difference of the ends for the springs between a[i] and b[i], one spring per lane.
/// Computes the difference of the velocities only if the springs are damped.
template <bool damped>
HWY_INLINE Stretch<float> Take(const uint16_t* a, const uint16_t* b, const Motion<float>* motions) {
  const Lanes<float> l;
  const float* p = motions->position;  // the upper half of the vector receives the velocity
  const auto low = Transpose(Difference(p, a[0], b[0]), Difference(p, a[1], b[1]),
                             Difference(p, a[2], b[2]), Difference(p, a[3], b[3]));
  const auto high = Transpose(Difference(p, a[4], b[4]), Difference(p, a[5], b[5]),
                              Difference(p, a[6], b[6]), Difference(p, a[7], b[7]));
  Stretch<float> taken;
  taken.way = {hn::ConcatLowerLower(l, high.x, low.x), hn::ConcatLowerLower(l, high.y, low.y),
               hn::ConcatLowerLower(l, high.z, low.z)};
  if constexpr (damped) {
    taken.speed = {hn::ConcatUpperUpper(l, high.x, low.x), hn::ConcatUpperUpper(l, high.y, low.y),
                   hn::ConcatUpperUpper(l, high.z, low.z)};
  }
  return taken;
}
template <bool damped>
HWY_INLINE Stretch<double> Take(const uint16_t* a, const uint16_t* b,
                                const Motion<double>* motions) {
  const double *p = motions->position, *v = motions->velocity;
  Stretch<double> taken;
  taken.way = Transpose(Difference(p, a[0], b[0]), Difference(p, a[1], b[1]),
                        Difference(p, a[2], b[2]), Difference(p, a[3], b[3]));
  if constexpr (damped) {
    taken.speed = Transpose(Difference(v, a[0], b[0]), Difference(v, a[1], b[1]),
                            Difference(v, a[2], b[2]), Difference(v, a[3], b[3]));
  }
  return taken;
}

/// Stores the forces of the springs, one spring per lane.
HWY_INLINE void Give(const Axes<float>& force, float (*forces)[4]) {
  const Lanes<float> l;
  const auto zero = hn::Zero(l);
  const auto xz = hn::InterleaveLower(l, force.x, force.z);
  const auto y0 = hn::InterleaveLower(l, force.y, zero);
  const auto xz2 = hn::InterleaveUpper(l, force.x, force.z);
  const auto y02 = hn::InterleaveUpper(l, force.y, zero);
  const auto f04 = hn::InterleaveLower(l, xz, y0), f15 = hn::InterleaveUpper(l, xz, y0);
  const auto f26 = hn::InterleaveLower(l, xz2, y02), f37 = hn::InterleaveUpper(l, xz2, y02);
  hn::Store(hn::ConcatLowerLower(l, f15, f04), l, forces[0]);
  hn::Store(hn::ConcatLowerLower(l, f37, f26), l, forces[2]);
  hn::Store(hn::ConcatUpperUpper(l, f15, f04), l, forces[4]);
  hn::Store(hn::ConcatUpperUpper(l, f37, f26), l, forces[6]);
}
HWY_INLINE void Give(const Axes<double>& force, double (*forces)[4]) {
  const Lanes<double> l;
  const auto zero = hn::Zero(l);
  const auto xy = hn::InterleaveLower(l, force.x, force.y);
  const auto z0 = hn::InterleaveLower(l, force.z, zero);
  const auto xy2 = hn::InterleaveUpper(l, force.x, force.y);
  const auto z02 = hn::InterleaveUpper(l, force.z, zero);
  hn::Store(hn::ConcatLowerLower(l, z0, xy), l, forces[0]);
  hn::Store(hn::ConcatLowerLower(l, z02, xy2), l, forces[1]);
  hn::Store(hn::ConcatUpperUpper(l, z0, xy), l, forces[2]);
  hn::Store(hn::ConcatUpperUpper(l, z02, xy2), l, forces[3]);
}

/// Loads the motion of a body. Each load reads three numbers and the number behind them, so the row
/// must not be the last row of the column.
template <class Real>
HWY_INLINE void TakeMotion(const Vec3<Real>& position, const Vec3<Real>& velocity,
                           Motion<Real>& motion) {
  const Four<Real> four;
  hn::Store(hn::LoadU(four, &position.x), four, motion.position);
  hn::Store(hn::LoadU(four, &velocity.x), four, motion.velocity);
}
template <class Real>
void TakeLastMotion(const Vec3<Real>& p, const Vec3<Real>& v, Motion<Real>& motion) {
  motion = {{p.x, p.y, p.z, 0}, {v.x, v.y, v.z, 0}};
}

template <class Real>
void TakeMotions(const Vec3<Real>* position, const Vec3<Real>* velocity, uint64_t bodies,
                 const uint32_t* rows, uint64_t first, uint64_t count, Motion<Real>* motions) {
  const uint64_t last = bodies - 1;
  if (rows == nullptr) {
    const uint64_t end = std::min(first + count, last);
    for (uint64_t row = first; row < end; ++row) {
      TakeMotion(position[row], velocity[row], motions[row - first]);
    }
    if (end < first + count) TakeLastMotion(position[last], velocity[last], motions[last - first]);
    return;
  }
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t row = rows[i];
    if (row < last) {
      TakeMotion(position[row], velocity[row], motions[i]);
    } else {
      TakeLastMotion(position[row], velocity[row], motions[i]);
    }
  }
}

/// Calls visit(pull) for the pulls from `at` to `end`. Each iteration handles several pulls, which
/// is faster.
template <class Visit>
HWY_INLINE const uint16_t* ForEachPull(const uint16_t* at, const uint16_t* end, Visit&& visit) {
  constexpr int kRound = 4;
  for (; end - at >= kRound; at += kRound) {
#pragma GCC unroll 4
    for (int i = 0; i < kRound; ++i) visit(at[i]);
  }
  for (; at < end; ++at) visit(*at);
  return at;
}

template <class Real>
void SumUp(const Forces<Real>* forces, const uint16_t* pulls, const uint16_t* pull_counts,
           uint64_t count, Vec3<Real>* sums) {
  const Four<Real> four;
  const auto* all = reinterpret_cast<const Real*>(forces);
  const uint16_t* at = pulls;
  for (uint64_t i = 0; i < count; ++i) {
    AskAhead(at, 1);
    auto sum = hn::Zero(four);
    at = ForEachPull(at, at + pull_counts[2 * i],
                     [&](uint64_t pull) { sum = hn::Add(sum, hn::Load(four, all + 4 * pull)); });
    at = ForEachPull(at, at + pull_counts[2 * i + 1],
                     [&](uint64_t pull) { sum = hn::Sub(sum, hn::Load(four, all + 4 * pull)); });
    HWY_ALIGN Real components[4];
    hn::Store(sum, four, components);
    sums[i] += {components[0], components[1], components[2]};
  }
}

#else  // vectors too short for a body

template <bool damped, class Real>
Stretch<Real> Take(const uint16_t* a, const uint16_t* b, const Motion<Real>* motions) {
  const Motion<Real>&from = motions[*a], &to = motions[*b];
  const auto difference = [](const Real* first, const Real* second) {
    const Lanes<Real> l;
    return Axes<Real>{hn::Set(l, second[0] - first[0]), hn::Set(l, second[1] - first[1]),
                      hn::Set(l, second[2] - first[2])};
  };
  return {difference(from.position, to.position), difference(from.velocity, to.velocity)};
}

template <class Real>
void Give(const Axes<Real>& force, Real (*forces)[4]) {
  forces[0][0] = hn::GetLane(force.x);
  forces[0][1] = hn::GetLane(force.y);
  forces[0][2] = hn::GetLane(force.z);
}

template <class Real>
void TakeMotions(const Vec3<Real>* position, const Vec3<Real>* velocity, uint64_t,
                 const uint32_t* rows, uint64_t first, uint64_t count, Motion<Real>* motions) {
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t row = rows == nullptr ? first + i : rows[i];
    const Vec3<Real>&p = position[row], &v = velocity[row];
    motions[i] = {{p.x, p.y, p.z, 0}, {v.x, v.y, v.z, 0}};
  }
}

template <class Real>
void SumUp(const Forces<Real>* forces, const uint16_t* pulls, const uint16_t* pull_counts,
           uint64_t count, Vec3<Real>* sums) {
  const auto force = [&](uint16_t pull) {
    const Real* f = forces[pull / kBatch].value[pull % kBatch];
    return Vec3<Real>{f[0], f[1], f[2]};
  };
  for (uint64_t i = 0; i < count; ++i) {
    Vec3<Real> sum;
    for (const uint16_t* end = pulls + pull_counts[2 * i]; pulls < end;) sum += force(*pulls++);
    for (const uint16_t* end = pulls + pull_counts[2 * i + 1]; pulls < end;) sum -= force(*pulls++);
    sums[i] += sum;
  }
}

#endif

/// Loads the bodies at the ends of the springs, from a slot on. Loads the last springs again beyond
/// the last slot.
template <bool damped, class Real>
HWY_INLINE Stretch<Real> TakeFrom(const TileSprings<Real>& springs, uint64_t slot,
                                  const Motion<Real>* motions) {
  const uint64_t first = std::min(slot, springs.count - hn::MaxLanes(Lanes<Real>()));
  return Take<damped>(springs.first_ends + first, springs.second_ends + first, motions);
}

template <class Real>
HWY_INLINE V<Real> Dot(const Axes<Real>& a, const Axes<Real>& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

template <class Real>
HWY_INLINE Axes<Real> Scale(const Axes<Real>& a, V<Real> factor) {
  return {hn::Mul(a.x, factor), hn::Mul(a.y, factor), hn::Mul(a.z, factor)};
}

/// A distance vector with its length [m] and the inverse of the length.
template <class Real>
struct Measured {
  Stretch<Real> stretch;
  V<Real> distance, inverse;
};

template <class Real>
HWY_INLINE Measured<Real> Measure(const Stretch<Real>& stretch) {
  const auto distance = hn::Sqrt(Dot(stretch.way, stretch.way));
  return {stretch, distance, hn::Div(hn::Set(Lanes<Real>(), Real(1)), distance)};
}

/// Properties of the springs of a batch.
template <class Real>
struct Values {
  const Real *length, *hooke, *damping;  // [m], [N/m], [N s/m]
};

/// Gathers values from rows that are not adjacent.
template <class Real>
Values<Real> Collect(const TileSprings<Real>& springs, const uint32_t* rows,
                     Real (&copies)[3][kBatch]) {
  const Real* columns[] = {springs.length, springs.hooke, springs.damping};
  for (int c = 0; c < 3 && columns[c] != nullptr; ++c) {
    for (uint32_t i = 0; i < kBatch; ++i) copies[c][i] = columns[c][rows[i]];
  }
  return {copies[0], copies[1], copies[2]};
}

/// Returns pointers to the properties of the batch that begins at `slot`. They point into the
/// columns, or into `copies`, where the values are gathered. Prefetches the properties of the next
/// batch.
template <bool damped, class Real>
HWY_INLINE Values<Real> ValuesOf(const TileSprings<Real>& springs, uint64_t slot,
                                 Real (&copies)[3][kBatch]) {
  AskAhead(springs.first_ends + slot, kBatch);
  AskAhead(springs.second_ends + slot, kBatch);
  uint64_t row = slot;
  if (springs.rows != nullptr) {
    row = springs.first_rows[slot / kBatch];
    if (row == kScattered) return Collect(springs, springs.rows + slot, copies);
  }
  AskAhead(springs.length + row, kBatch);
  AskAhead(springs.hooke + row, kBatch);
  if constexpr (damped) AskAhead(springs.damping + row, kBatch);
  return {springs.length + row, springs.hooke + row, damped ? springs.damping + row : nullptr};
}

/** Computes the forces of one vector of springs on their first ends [N]. The vector begins at index
 *  `first` of its batch. A spring whose ends coincide has no direction and exerts no force. */
template <bool damped, class Real>
HWY_INLINE Axes<Real> Pull(const Measured<Real>& measured, const Values<Real>& values,
                           uint32_t first) {
  const Lanes<Real> l;
  const Axes<Real> direction = Scale(measured.stretch.way, measured.inverse);
  auto pull = hn::Mul(hn::LoadU(l, values.hooke + first),
                      hn::Sub(measured.distance, hn::LoadU(l, values.length + first)));
  if constexpr (damped) {
    const auto speed = Dot(measured.stretch.speed, direction);
    pull = hn::Add(pull, hn::Mul(hn::LoadU(l, values.damping + first), speed));
  }
  const auto none = hn::Eq(measured.distance, hn::Zero(l));
  const Axes<Real> force = Scale(direction, pull);
  return {hn::IfThenZeroElse(none, force.x), hn::IfThenZeroElse(none, force.y),
          hn::IfThenZeroElse(none, force.z)};
}

/** Processes springs in three dependent stages: load the ends, measure, and compute the force.
 *  Three vectors of springs are processed at the same time, to hide latencies. The next vector
 *  is measured and the third vector is loaded while the forces of the first vector are computed. */
template <bool damped, class Real>
void PullAll(TileSprings<Real> springs, const Motion<Real>* motions, Forces<Real>* forces) {
  constexpr uint32_t kLanes = hn::MaxLanes(Lanes<Real>());
  HWY_ALIGN Real copies[3][kBatch];
  Measured<Real> measured = Measure(TakeFrom<damped>(springs, 0, motions));
  Stretch<Real> taken = TakeFrom<damped>(springs, kLanes, motions);
  for (uint64_t slot = 0; slot < springs.count; slot += kBatch, ++forces) {
    const Values<Real> values = ValuesOf<damped>(springs, slot, copies);
#pragma GCC unroll 1  // slower otherwise
    for (uint32_t i = 0; i < kBatch; i += kLanes) {
      const Measured<Real> group = measured;
      measured = Measure(taken);
      taken = TakeFrom<damped>(springs, slot + i + 2 * kLanes, motions);
      Give(Pull<damped>(group, values, i), forces->value + i);
    }
  }
}

template <class Real>
void PullOrDamp(const TileSprings<Real>& springs, const Motion<Real>* motions,
                Forces<Real>* forces) {
  if (springs.damping != nullptr) {
    PullAll<true>(springs, motions, forces);
  } else {
    PullAll<false>(springs, motions, forces);
  }
}

template <class Real>
TileForces<Real> Make() {
  return {hwy::TargetName(HWY_TARGET), &TakeMotions<Real>, &PullOrDamp<Real>, &SumUp<Real>};
}

}  // namespace vesper::hooke_spring::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vesper::hooke_spring {

// This function selects the loops itself. Highway's own selection is in a shared library, and a law
// must not need a shared library.
template <class Real>
std::vector<TileForces<Real>> AvailableTileForces() {
  std::vector<TileForces<Real>> available;
#if HWY_ARCH_X86_64
  const InstructionSet best = BestInstructionSet();
  if (best == InstructionSet::kAvx512) available.push_back(N_AVX3::Make<Real>());
  if (best != InstructionSet::kBaseline) available.push_back(N_AVX2::Make<Real>());
#endif
  available.push_back(HWY_STATIC_DISPATCH(Make<Real>)());
  return available;
}

template std::vector<TileForces<float>> AvailableTileForces();
template std::vector<TileForces<double>> AvailableTileForces();

}  // namespace vesper::hooke_spring
#endif
