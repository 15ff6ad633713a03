// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "moves.cpp"
// The targets are AVX2, AVX-512 and the baseline of the processor family.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "moves.hpp"
#include "simd/instruction_set.hpp"

HWY_BEFORE_NAMESPACE();
namespace vesper::newton_motion::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32

/// Maps each lane of a vector of components to the index of the body that the component belongs to.
template <class Real, size_t lanes>
struct Owners {
  alignas(64) hwy::MakeSigned<Real> body[3 * lanes];
  constexpr Owners() : body() {
    for (size_t i = 0; i < 3 * lanes; ++i) body[i] = static_cast<hwy::MakeSigned<Real>>(i / 3);
  }
};

/// Moves one body per lane, starting with row `row`.
template <class D, class Real = hn::TFromD<D>>
HWY_INLINE void MoveLanes(D d, const Bodies<Real>& bodies, uint64_t row, Real dt) {
  constexpr size_t kLanes = hn::MaxLanes(D());
  static constexpr Owners<Real, kLanes> kOwners;
  const auto mass = hn::LoadU(d, bodies.mass + row);
  const auto inverse = hn::Div(hn::Set(d, Real(1)), mass);
  const Real* f = &bodies.force[row].x;
  Real *v = &bodies.velocity[row].x, *x = &bodies.position[row].x;
  for (size_t first = 0; first < 3 * kLanes; first += kLanes) {
    const auto of_body = hn::SetTableIndices(d, kOwners.body + first);
    const auto immovable = hn::Eq(hn::TableLookupLanes(mass, of_body), hn::Zero(d));
    const auto velocity = hn::LoadU(d, v + first), position = hn::LoadU(d, x + first);
    const auto acceleration =
        hn::Mul(hn::LoadU(d, f + first), hn::TableLookupLanes(inverse, of_body));
    const auto moving = hn::Add(velocity, hn::Mul(acceleration, hn::Set(d, dt)));
    const auto moved = hn::Add(position, hn::Mul(moving, hn::Set(d, dt)));
    hn::StoreU(hn::IfThenElse(immovable, velocity, moving), d, v + first);
    hn::StoreU(hn::IfThenElse(immovable, position, moved), d, x + first);
  }
}

#endif

template <class Real>
void Move(const Bodies<Real>& bodies, uint64_t begin, uint64_t end, Real dt) {
#if HWY_MAX_BYTES >= 32
  const hn::ScalableTag<Real> d;
  for (; end - begin >= hn::MaxLanes(d); begin += hn::MaxLanes(d)) {
    MoveLanes(d, bodies, begin, dt);
  }
#endif
  for (uint64_t i = begin; i < end; ++i) {
    if (bodies.mass[i] == 0) continue;
    bodies.velocity[i] += bodies.force[i] * (1 / bodies.mass[i]) * dt;
    bodies.position[i] += bodies.velocity[i] * dt;
  }
}

template <class Real>
Moves<Real> Make() {
  return {hwy::TargetName(HWY_TARGET), &Move<Real>};
}

}  // namespace vesper::newton_motion::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vesper::newton_motion {

// This function selects the loops itself. Highway's own selection is in a shared library, and a law
// must not need a shared library.
template <class Real>
std::vector<Moves<Real>> AvailableMoves() {
  std::vector<Moves<Real>> available;
#if HWY_ARCH_X86_64
  const InstructionSet best = BestInstructionSet();
  if (best == InstructionSet::kAvx512) available.push_back(N_AVX3::Make<Real>());
  if (best != InstructionSet::kBaseline) available.push_back(N_AVX2::Make<Real>());
#endif
  available.push_back(HWY_STATIC_DISPATCH(Make<Real>)());
  return available;
}

template std::vector<Moves<float>> AvailableMoves();
template std::vector<Moves<double>> AvailableMoves();

}  // namespace vesper::newton_motion
#endif
