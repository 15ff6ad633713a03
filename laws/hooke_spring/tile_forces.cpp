#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tile_forces.cpp"
// Beside AVX2 and AVX-512 only what every processor of the family has.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>

#include "all_pairs/instruction_set.hpp"
#include "tile_forces.hpp"

HWY_BEFORE_NAMESPACE();
namespace vesper::hooke_spring::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Springs that go through a stage before the next stage begins: each stage alone is short enough
// for the processor to work on several batches at once.
constexpr uint64_t kBlock = 64;
// How far ahead memory is asked for [bytes]. What is read in order is longer than a page, where the
// processor stops looking ahead.
constexpr uint64_t kAhead = 1024;

/// Asks for the memory of `count` values beyond what is read now.
template <class T>
HWY_INLINE void AskAhead(const T* values, uint64_t count) {
  for (uint64_t byte = 0; byte < count * sizeof(T); byte += 64) {
    __builtin_prefetch(reinterpret_cast<const char*>(values) + kAhead + byte);
  }
}

/// From the first to the second end of each spring of a block; then its force on the first end.
template <class Real>
struct alignas(64) Block {
  Real x[kBlock], y[kBlock], z[kBlock];     // [m], then [N]
  Real vx[kBlock], vy[kBlock], vz[kBlock];  // [m/s]
};

#if HWY_MAX_BYTES >= 32

/// Vectors of 256 bits, and the four numbers that belong to a body.
template <class Real>
using Lanes = hn::CappedTag<Real, 32 / sizeof(Real)>;
template <class Real>
using Four = hn::CappedTag<Real, 4>;
template <class Real>
using V = hn::Vec<Lanes<Real>>;

/// Components of as many springs as there are lanes.
template <class Real>
struct Axes {
  V<Real> x, y, z;
};

/// Rows of three numbers, and what is behind them, as columns: per half of the vectors in float.
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

/// Second minus first end, of positions or velocities of motions.
template <class Real>
HWY_INLINE V<Real> Difference(const Real* values, uint16_t first, uint16_t second) {
  constexpr uint64_t kStride = sizeof(Motion<Real>) / sizeof(Real);
  const Lanes<Real> l;
  return hn::Sub(hn::Load(l, values + kStride * second), hn::Load(l, values + kStride * first));
}

/// A batch of springs, into place `at` of the block.
template <bool damped>
HWY_INLINE void Take(const uint16_t* a, const uint16_t* b, const Motion<float>* motions,
                     uint64_t at, Block<float>& block) {
  const Lanes<float> l;
  const float* p = motions->position;  // and the velocity in the upper half
  for (uint64_t i = 0; i < kBatch; i += 8, a += 8, b += 8, at += 8) {
    const auto low = Transpose(Difference(p, a[0], b[0]), Difference(p, a[1], b[1]),
                               Difference(p, a[2], b[2]), Difference(p, a[3], b[3]));
    const auto high = Transpose(Difference(p, a[4], b[4]), Difference(p, a[5], b[5]),
                                Difference(p, a[6], b[6]), Difference(p, a[7], b[7]));
    hn::Store(hn::ConcatLowerLower(l, high.x, low.x), l, block.x + at);
    hn::Store(hn::ConcatLowerLower(l, high.y, low.y), l, block.y + at);
    hn::Store(hn::ConcatLowerLower(l, high.z, low.z), l, block.z + at);
    if constexpr (damped) {
      hn::Store(hn::ConcatUpperUpper(l, high.x, low.x), l, block.vx + at);
      hn::Store(hn::ConcatUpperUpper(l, high.y, low.y), l, block.vy + at);
      hn::Store(hn::ConcatUpperUpper(l, high.z, low.z), l, block.vz + at);
    }
  }
}
template <bool damped>
HWY_INLINE void Take(const uint16_t* a, const uint16_t* b, const Motion<double>* motions,
                     uint64_t at, Block<double>& block) {
  const Lanes<double> l;
  const double *p = motions->position, *v = motions->velocity;
  for (uint64_t i = 0; i < kBatch; i += 4) {
    const auto d = Transpose(Difference(p, a[i], b[i]), Difference(p, a[i + 1], b[i + 1]),
                             Difference(p, a[i + 2], b[i + 2]), Difference(p, a[i + 3], b[i + 3]));
    hn::Store(d.x, l, block.x + at + i);
    hn::Store(d.y, l, block.y + at + i);
    hn::Store(d.z, l, block.z + at + i);
    if constexpr (damped) {
      const auto u =
          Transpose(Difference(v, a[i], b[i]), Difference(v, a[i + 1], b[i + 1]),
                    Difference(v, a[i + 2], b[i + 2]), Difference(v, a[i + 3], b[i + 3]));
      hn::Store(u.x, l, block.vx + at + i);
      hn::Store(u.y, l, block.vy + at + i);
      hn::Store(u.z, l, block.vz + at + i);
    }
  }
}

/// The forces at place `at` of the block.
HWY_INLINE void Give(const Block<float>& block, uint64_t at, Forces<float>& forces) {
  const Lanes<float> l;
  const auto zero = hn::Zero(l);
  for (uint64_t i = 0; i < kBatch; i += 8) {
    const auto x = hn::Load(l, block.x + at + i), y = hn::Load(l, block.y + at + i),
               z = hn::Load(l, block.z + at + i);
    const auto xz = hn::InterleaveLower(l, x, z), y0 = hn::InterleaveLower(l, y, zero);
    const auto xz2 = hn::InterleaveUpper(l, x, z), y02 = hn::InterleaveUpper(l, y, zero);
    const auto f04 = hn::InterleaveLower(l, xz, y0), f15 = hn::InterleaveUpper(l, xz, y0);
    const auto f26 = hn::InterleaveLower(l, xz2, y02), f37 = hn::InterleaveUpper(l, xz2, y02);
    hn::Store(hn::ConcatLowerLower(l, f15, f04), l, forces.value[i]);
    hn::Store(hn::ConcatLowerLower(l, f37, f26), l, forces.value[i + 2]);
    hn::Store(hn::ConcatUpperUpper(l, f15, f04), l, forces.value[i + 4]);
    hn::Store(hn::ConcatUpperUpper(l, f37, f26), l, forces.value[i + 6]);
  }
}
HWY_INLINE void Give(const Block<double>& block, uint64_t at, Forces<double>& forces) {
  const Lanes<double> l;
  for (uint64_t i = 0; i < kBatch; i += 4) {
    const auto x = hn::Load(l, block.x + at + i), y = hn::Load(l, block.y + at + i),
               z = hn::Load(l, block.z + at + i), zero = hn::Zero(l);
    const auto xy = hn::InterleaveLower(l, x, y), z0 = hn::InterleaveLower(l, z, zero);
    const auto xy2 = hn::InterleaveUpper(l, x, y), z02 = hn::InterleaveUpper(l, z, zero);
    hn::Store(hn::ConcatLowerLower(l, z0, xy), l, forces.value[i]);
    hn::Store(hn::ConcatLowerLower(l, z02, xy2), l, forces.value[i + 1]);
    hn::Store(hn::ConcatUpperUpper(l, z0, xy), l, forces.value[i + 2]);
    hn::Store(hn::ConcatUpperUpper(l, z02, xy2), l, forces.value[i + 3]);
  }
}

template <class Real>
void TakeMotions(const Vec3<Real>* position, const Vec3<Real>* velocity, uint64_t bodies,
                 const uint32_t* rows, uint64_t first, uint64_t count, Motion<Real>* motions) {
  const Four<Real> four;
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t row = rows == nullptr ? first + i : rows[i];
    const Vec3<Real> &p = position[row], &v = velocity[row];
    if (row + 1 < bodies) {  // nothing may be read behind the last row
      hn::Store(hn::LoadU(four, &p.x), four, motions[i].position);
      hn::Store(hn::LoadU(four, &v.x), four, motions[i].velocity);
    } else {
      motions[i] = {{p.x, p.y, p.z, 0}, {v.x, v.y, v.z, 0}};
    }
  }
}

/// Calls visit(pull) for those from `at` up to `end`; several in a round, for that costs less.
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

#else  // vectors too short to hold a body

template <bool damped, class Real>
void Take(const uint16_t* a, const uint16_t* b, const Motion<Real>* motions, uint64_t at,
          Block<Real>& block) {
  for (uint64_t i = 0; i < kBatch; ++i) {
    const Motion<Real>&from = motions[a[i]], &to = motions[b[i]];
    block.x[at + i] = to.position[0] - from.position[0];
    block.y[at + i] = to.position[1] - from.position[1];
    block.z[at + i] = to.position[2] - from.position[2];
    block.vx[at + i] = to.velocity[0] - from.velocity[0];
    block.vy[at + i] = to.velocity[1] - from.velocity[1];
    block.vz[at + i] = to.velocity[2] - from.velocity[2];
  }
}

template <class Real>
void Give(const Block<Real>& block, uint64_t at, Forces<Real>& forces) {
  for (uint64_t i = 0; i < kBatch; ++i) {
    forces.value[i][0] = block.x[at + i];
    forces.value[i][1] = block.y[at + i];
    forces.value[i][2] = block.z[at + i];
  }
}

template <class Real>
void TakeMotions(const Vec3<Real>* position, const Vec3<Real>* velocity, uint64_t,
                 const uint32_t* rows, uint64_t first, uint64_t count, Motion<Real>* motions) {
  for (uint64_t i = 0; i < count; ++i) {
    const uint64_t row = rows == nullptr ? first + i : rows[i];
    const Vec3<Real> &p = position[row], &v = velocity[row];
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

/// Of springs whose rows follow each other from `row` on, or are at `rows`.
template <class D, class Real = hn::TFromD<D>>
HWY_INLINE hn::Vec<D> Values(D d, const Real* column, uint32_t row, const uint32_t* rows) {
  if (HWY_LIKELY(row != kScattered)) return hn::LoadU(d, column + row);
  HWY_ALIGN Real values[hn::MaxLanes(d)];
  for (size_t i = 0; i < hn::MaxLanes(d); ++i) values[i] = column[rows[i]];
  return hn::Load(d, values);
}

/** Turns differences into forces, from slot `first` of the springs on. A spring whose ends coincide
 *  has no direction, and exerts none. */
template <bool damped, class Real>
HWY_INLINE void Pull(const TileSprings<Real>& springs, uint64_t first, uint64_t count,
                     Block<Real>& block) {
  const hn::CappedTag<Real, kBatch> d;
  for (uint64_t i = 0; i < count; i += hn::MaxLanes(d)) {
    const uint64_t slot = first + i;
    auto row = static_cast<uint32_t>(slot);
    const uint32_t* rows = nullptr;
    if (springs.rows != nullptr) {
      rows = springs.rows + slot;
      row = springs.first_rows[slot / kBatch];
      if (row != kScattered) row += slot % kBatch;
    }
    if (HWY_LIKELY(row != kScattered)) {
      AskAhead(springs.hooke + row, hn::MaxLanes(d));
      AskAhead(springs.length + row, hn::MaxLanes(d));
      if constexpr (damped) AskAhead(springs.damping + row, hn::MaxLanes(d));
    }
    auto x = hn::Load(d, block.x + i), y = hn::Load(d, block.y + i), z = hn::Load(d, block.z + i);
    const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
    const auto distance = hn::Sqrt(square);
    const auto inverse = hn::Div(hn::Set(d, Real(1)), distance);
    x = hn::Mul(x, inverse), y = hn::Mul(y, inverse), z = hn::Mul(z, inverse);
    auto pull = hn::Mul(Values(d, springs.hooke, row, rows),
                        hn::Sub(distance, Values(d, springs.length, row, rows)));
    if constexpr (damped) {
      const auto vx = hn::Load(d, block.vx + i), vy = hn::Load(d, block.vy + i),
                 vz = hn::Load(d, block.vz + i);
      const auto speed = hn::Add(hn::Add(hn::Mul(vx, x), hn::Mul(vy, y)), hn::Mul(vz, z));
      pull = hn::Add(pull, hn::Mul(Values(d, springs.damping, row, rows), speed));
    }
    const auto none = hn::Eq(distance, hn::Zero(d));
    hn::Store(hn::IfThenZeroElse(none, hn::Mul(x, pull)), d, block.x + i);
    hn::Store(hn::IfThenZeroElse(none, hn::Mul(y, pull)), d, block.y + i);
    hn::Store(hn::IfThenZeroElse(none, hn::Mul(z, pull)), d, block.z + i);
  }
}

template <bool damped, class Real>
HWY_INLINE void PullAll(const TileSprings<Real>& springs, const Motion<Real>* motions,
                        Forces<Real>* forces) {
  Block<Real> block;
  for (uint64_t first = 0; first < springs.count; first += kBlock) {
    const uint64_t count = std::min(kBlock, springs.count - first);
    AskAhead(springs.first_ends + first, kBlock);
    AskAhead(springs.second_ends + first, kBlock);
    for (uint64_t i = 0; i < count; i += kBatch) {
      Take<damped>(springs.first_ends + first + i, springs.second_ends + first + i, motions, i,
                   block);
    }
    Pull<damped>(springs, first, count, block);
    for (uint64_t i = 0; i < count; i += kBatch) Give(block, i, forces[(first + i) / kBatch]);
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

// Highway's own dispatch lives in a shared library, which a law must not need.
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
