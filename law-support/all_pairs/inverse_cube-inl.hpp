// SPDX-License-Identifier: Apache-2.0
// The power r^-3 = (r^2)^(-3/2). Highway includes this file once for each target (instruction set).
#if defined(VESPER_ALL_PAIRS_INVERSE_CUBE) == defined(HWY_TARGET_TOGGLE)
#ifdef VESPER_ALL_PAIRS_INVERSE_CUBE
#undef VESPER_ALL_PAIRS_INVERSE_CUBE
#else
#define VESPER_ALL_PAIRS_INVERSE_CUBE
#endif

#include <concepts>
#include <cstdint>

#include "hwy/highway.h"
#include "simd/fused-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace vesper {
namespace HWY_NAMESPACE {

/// Computes r^-3 from r^2 > 0 with arithmetic only.
struct PortableRoot {
  /// The first estimate of r^-1 halves the exponent with integer operations (the relative error of
  /// its square is below 0.0682). A polynomial in that error, fitted by the Remez algorithm,
  /// reduces the relative error to at most 2.5e-7.
  template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
    requires std::same_as<hwy::HWY_NAMESPACE::TFromD<D>, float>
  static HWY_INLINE V InverseCube(D d, V r2) {
    namespace hn = hwy::HWY_NAMESPACE;
    const hn::RebindToUnsigned<D> bits;
    const V guess = hn::BitCast(
        d, hn::Sub(hn::Set(bits, 0x5f374740u), hn::ShiftRight<1>(hn::BitCast(bits, r2))));
    const V square = hn::Mul(guess, guess);
    const V error = FusedMinus(d, r2, square, hn::Set(d, 1.0f));
    V p = hn::Set(d, 2.475466067017039f);
    p = Fused(d, p, error, hn::Set(d, 2.2033037681568617f));
    p = Fused(d, p, error, hn::Set(d, 1.874992191764453f));
    p = Fused(d, p, error, hn::Set(d, 1.499981628924616f));
    p = Fused(d, p, error, hn::Set(d, 0.9999999929482946f));
    return hn::Mul(hn::Mul(guess, square), p);
  }

  /// Does the same for f64, in two steps; after the first step the error is below 1.5e-6.
  template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
    requires std::same_as<hwy::HWY_NAMESPACE::TFromD<D>, double>
  static HWY_INLINE V InverseCube(D d, V r2) {
    namespace hn = hwy::HWY_NAMESPACE;
    const hn::RebindToUnsigned<D> bits;
    const V one = hn::Set(d, 1.0);
    const V guess = hn::BitCast(d, hn::Sub(hn::Set(bits, uint64_t{0x5fe6e8e800000000}),
                                           hn::ShiftRight<1>(hn::BitCast(bits, r2))));
    V error = FusedMinus(d, r2, hn::Mul(guess, guess), one);
    V p = hn::Set(d, 0.31390734536595183);
    p = Fused(d, p, error, hn::Set(d, 0.3762752079965376));
    p = Fused(d, p, error, hn::Set(d, 0.49999843251860854));
    p = Fused(d, p, error, hn::Set(d, 0.999999258434372));
    const V inverse = hn::Mul(guess, p);
    const V square = hn::Mul(inverse, inverse);
    error = FusedMinus(d, r2, square, one);
    p = Fused(d, hn::Set(d, 1.875), error, hn::Set(d, 1.5));
    return hn::Mul(hn::Mul(inverse, square), Fused(d, p, error, one));
  }
};

/// Computes r^-3 from r^2 > 0 with the processor's approximation of r^-1 and a correction: the
/// first terms of (1 - e)^(-3/2), where e is the error of the approximation's square.
struct ApproximateRoot {
  /// If the processor's approximation has 14 bits, two terms reduce the error to 3e-8. If it has 12
  /// bits or fewer, three terms reduce the error to 1e-7.
  template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
    requires std::same_as<hwy::HWY_NAMESPACE::TFromD<D>, float>
  static HWY_INLINE V InverseCube(D d, V r2) {
    namespace hn = hwy::HWY_NAMESPACE;
    const V one = hn::Set(d, 1.0f), guess = hn::ApproximateReciprocalSqrt(r2);
    const V square = hn::Mul(guess, guess);
    const V error = FusedMinus(d, r2, square, one);
    V p = hn::Set(d, 1.5f);
    if constexpr (HWY_TARGET != HWY_AVX3) p = Fused(d, hn::Set(d, 1.875f), error, p);
    return hn::Mul(hn::Mul(guess, square), Fused(d, p, error, one));
  }

  /// For f64, only AVX-512 has an approximation. It has 14 bits, and four terms reduce the error to
  /// 1e-15.
  template <class D, class V = hwy::HWY_NAMESPACE::Vec<D>>
    requires std::same_as<hwy::HWY_NAMESPACE::TFromD<D>, double>
  static HWY_INLINE V InverseCube(D d, V r2) {
#if HWY_TARGET == HWY_AVX3
    namespace hn = hwy::HWY_NAMESPACE;
    const V one = hn::Set(d, 1.0), guess{_mm512_rsqrt14_pd(r2.raw)};
    const V square = hn::Mul(guess, guess);
    const V error = FusedMinus(d, r2, square, one);
    V p = Fused(d, hn::Set(d, 2.1875), error, hn::Set(d, 1.875));
    p = Fused(d, p, error, hn::Set(d, 1.5));
    return hn::Mul(hn::Mul(guess, square), Fused(d, p, error, one));
#else
    return PortableRoot::InverseCube(d, r2);
#endif
  }
};

}  // namespace HWY_NAMESPACE
}  // namespace vesper
HWY_AFTER_NAMESPACE();

#endif
