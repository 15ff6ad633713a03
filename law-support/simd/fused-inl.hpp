// SPDX-License-Identifier: Apache-2.0
// Multiplication and addition with one rounding. Highway includes this file once for each target
// (instruction set).
#if defined(VESPER_SIMD_FUSED) == defined(HWY_TARGET_TOGGLE)
#ifdef VESPER_SIMD_FUSED
#undef VESPER_SIMD_FUSED
#else
#define VESPER_SIMD_FUSED
#endif

#include <cmath>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace vesper {
namespace HWY_NAMESPACE {

/// Computes a * b + c with one rounding on every processor.
template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
HWY_INLINE V Fused(D d, V a, V b, V c) {
  namespace hn = hwy::HWY_NAMESPACE;
#if HWY_NATIVE_FMA
  (void)d;
  return hn::MulAdd(a, b, c);
#else
  HWY_ALIGN hn::TFromD<D> x[hn::MaxLanes(d)], y[hn::MaxLanes(d)], z[hn::MaxLanes(d)];
  hn::Store(a, d, x);
  hn::Store(b, d, y);
  hn::Store(c, d, z);
  for (size_t i = 0; i < hn::MaxLanes(d); ++i) z[i] = std::fma(x[i], y[i], z[i]);
  return hn::Load(d, z);
#endif
}

/// Computes c - a * b with one rounding.
template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
HWY_INLINE V FusedMinus(D d, V a, V b, V c) {
#if HWY_NATIVE_FMA
  (void)d;
  return hwy::HWY_NAMESPACE::NegMulAdd(a, b, c);
#else
  return Fused(d, hwy::HWY_NAMESPACE::Neg(a), b, c);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace vesper
HWY_AFTER_NAMESPACE();

#endif
