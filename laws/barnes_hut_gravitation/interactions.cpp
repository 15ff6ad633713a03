// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactions.cpp"
// The targets are AVX2, AVX-512 and the baseline of the processor family.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include "all_pairs/inverse_cube-inl.hpp"
#include "all_pairs/pair_sums.hpp"
#include "interactions.hpp"

HWY_BEFORE_NAMESPACE();
namespace vesper::barnes_hut::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using vesper::HWY_NAMESPACE::Fused;
using vesper::HWY_NAMESPACE::FusedMinus;
using vesper::HWY_NAMESPACE::PortableRoot;

/// A vector of target bodies, which stays in registers while all sources are processed.
template <class D>
class Block {
 public:
  using Real = hn::TFromD<D>;
  using V = hn::Vec<D>;

  HWY_INLINE void Load(const Targets<Real>& targets, size_t at) {
    const D d;
    x_ = hn::Load(d, targets.x + at);
    y_ = hn::Load(d, targets.y + at);
    z_ = hn::Load(d, targets.z + at);
    ax_ = hn::Load(d, targets.ax + at);
    ay_ = hn::Load(d, targets.ay + at);
    az_ = hn::Load(d, targets.az + at);
  }
  HWY_INLINE void Store(Targets<Real>& targets, size_t at) const {
    const D d;
    hn::Store(ax_, d, targets.ax + at);
    hn::Store(ay_, d, targets.ay + at);
    hn::Store(az_, d, targets.az + at);
  }

  /// Adds the pull of a body, with w = m / (d^2 + softening2)^(3/2) and a += w d.
  HWY_INLINE void Add(const Source<Real>& source, V softening2) {
    const D d;
    const V dx = hn::Sub(hn::Set(d, source.position.x), x_);
    const V dy = hn::Sub(hn::Set(d, source.position.y), y_);
    const V dz = hn::Sub(hn::Set(d, source.position.z), z_);
    const V square = Square(dx, dy, dz, softening2);
    const V w = hn::Mul(hn::Set(d, source.mass), PortableRoot::InverseCube(d, square));
    ax_ = Fused(d, w, dx, ax_);
    ay_ = Fused(d, w, dy, ay_);
    az_ = Fused(d, w, dz, az_);
  }

  /// Adds the pull of a cell: a += m / r^3 [(1 + (5/2 (d.q) - 1/2 tr S) / r^2) d - q]. Here S is
  /// the matrix of the cell's second moments, r^2 = d^2 + softening2, and q = S d / r^2.
  HWY_INLINE void Add(const Multipole<Real>& cell, V softening2) {
    const D d;
    const V dx = hn::Sub(hn::Set(d, cell.centre.x), x_);
    const V dy = hn::Sub(hn::Set(d, cell.centre.y), y_);
    const V dz = hn::Sub(hn::Set(d, cell.centre.z), z_);
    const V inverse2 = hn::Div(hn::Set(d, Real{1}), Square(dx, dy, dz, softening2));
    const V w = hn::Mul(hn::Mul(hn::Set(d, cell.mass), inverse2), hn::Sqrt(inverse2));
    const V qx = hn::Mul(inverse2, Row(cell.xx, cell.xy, cell.xz, dx, dy, dz));
    const V qy = hn::Mul(inverse2, Row(cell.xy, cell.yy, cell.yz, dx, dy, dz));
    const V qz = hn::Mul(inverse2, Row(cell.xz, cell.yz, cell.zz, dx, dy, dz));
    const V dq = Fused(d, dx, qx, Fused(d, dy, qy, hn::Mul(dz, qz)));
    const V bracket = Fused(d, hn::Set(d, Real{2.5}), dq, hn::Set(d, Real{-0.5} * cell.trace));
    const V along = hn::Mul(w, Fused(d, bracket, inverse2, hn::Set(d, Real{1})));
    ax_ = FusedMinus(d, w, qx, Fused(d, along, dx, ax_));
    ay_ = FusedMinus(d, w, qy, Fused(d, along, dy, ay_));
    az_ = FusedMinus(d, w, qz, Fused(d, along, dz, az_));
  }

 private:
  static HWY_INLINE V Square(V dx, V dy, V dz, V softening2) {
    const D d;
    return Fused(d, dx, dx, Fused(d, dy, dy, Fused(d, dz, dz, softening2)));
  }
  static HWY_INLINE V Row(Real a, Real b, Real c, V dx, V dy, V dz) {
    const D d;
    return Fused(d, hn::Set(d, a), dx, Fused(d, hn::Set(d, b), dy, hn::Mul(hn::Set(d, c), dz)));
  }

  V x_, y_, z_, ax_, ay_, az_;
};

/// Calls each(block, block) for all targets, two vectors at a time, which hides the latency of a
/// square root.
template <class Real, class Each>
HWY_INLINE void ForBlocks(Targets<Real>& targets, const Each& each) {
  const hn::CappedTag<Real, kGroup / 2> d;
  const size_t lanes = hn::Lanes(d);
  for (size_t at = 0; at < kGroup; at += 2 * lanes) {
    Block<decltype(d)> one, two;
    one.Load(targets, at);
    two.Load(targets, at + lanes);
    each(one, two);
    one.Store(targets, at);
    two.Store(targets, at + lanes);
  }
}

template <class Real>
void AddBodies(Targets<Real>& targets, const Source<Real>* sources, const Run* runs, uint32_t count,
               Real softening2) {
  ForBlocks(targets, [&](auto& one, auto& two) HWY_ATTR {
    const auto e2 = hn::Set(hn::CappedTag<Real, kGroup / 2>(), softening2);
    for (const Run* run = runs; run != runs + count; ++run) {
      for (const Source<Real>*s = sources + run->first, *end = s + run->count; s != end; ++s) {
        one.Add(*s, e2);
        two.Add(*s, e2);
      }
    }
  });
}

template <class Real>
void AddCells(Targets<Real>& targets, const Multipole<Real>* cells, const uint32_t* list,
              uint32_t count, Real softening2) {
  ForBlocks(targets, [&](auto& one, auto& two) HWY_ATTR {
    const auto e2 = hn::Set(hn::CappedTag<Real, kGroup / 2>(), softening2);
    for (const uint32_t* cell = list; cell != list + count; ++cell) {
      one.Add(cells[*cell], e2);
      two.Add(cells[*cell], e2);
    }
  });
}

template <class Real>
Interactions<Real> Make() {
  return {hwy::TargetName(HWY_TARGET), &AddBodies<Real>, &AddCells<Real>};
}

}  // namespace vesper::barnes_hut::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vesper::barnes_hut {

// This function selects the loops itself. Highway's own selection is in a shared library, and a law
// must not need a shared library.
template <class Real>
std::vector<Interactions<Real>> AvailableInteractions() {
  std::vector<Interactions<Real>> available;
#if HWY_ARCH_X86_64
  const InstructionSet best = BestInstructionSet();
  if (best == InstructionSet::kAvx512) available.push_back(N_AVX3::Make<Real>());
  if (best != InstructionSet::kBaseline) available.push_back(N_AVX2::Make<Real>());
#endif
  available.push_back(HWY_STATIC_DISPATCH(Make<Real>)());
  return available;
}

template std::vector<Interactions<float>> AvailableInteractions();
template std::vector<Interactions<double>> AvailableInteractions();

}  // namespace vesper::barnes_hut
#endif
