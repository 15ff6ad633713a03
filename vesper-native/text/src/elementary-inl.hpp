// SPDX-License-Identifier: Apache-2.0
// Elementary functions on vectors of doubles. This file is included once for each target
// (instruction set) of Highway. The functions never fuse multiplication and addition, so that all
// targets give the same bits. Polynomials and constants are those of Sun Microsystems, fdlibm, 1993
// (public constants of its algorithms).
#if defined(VESPER_TEXT_ELEMENTARY) == defined(HWY_TARGET_TOGGLE)
#ifdef VESPER_TEXT_ELEMENTARY
#undef VESPER_TEXT_ELEMENTARY
#else
#define VESPER_TEXT_ELEMENTARY
#endif

#include <cstddef>
#include <limits>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace vesper::text {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class D>
using V64 = hn::Vec<D>;

/// Computes c[0] + x (c[1] + x (…)).
template <class D, size_t n>
HWY_INLINE V64<D> Polynomial(D d, V64<D> x, const double (&c)[n]) {
  auto sum = hn::Set(d, c[n - 1]);
  for (size_t i = n - 1; i-- > 0;) sum = hn::Add(hn::Mul(sum, x), hn::Set(d, c[i]));
  return sum;
}

/// Returns 2^k for whole k from -1022 to 1023.
template <class D>
HWY_INLINE V64<D> PowerOfTwo(D d, V64<D> k) {
  const hn::RebindToSigned<D> di;
  const auto biased = hn::Add(hn::ConvertTo(di, k), hn::Set(di, int64_t{1023}));
  return hn::BitCast(d, hn::ShiftLeft<52>(biased));
}

template <class D>
HWY_INLINE V64<D> Exp(D d, V64<D> x) {
  // Computes e^x = 2^k e^r with |r| <= ln 2 / 2, and e^r by its Taylor series up to r^13.
  static constexpr double kSeries[] = {1,
                                       1,
                                       1. / 2,
                                       1. / 6,
                                       1. / 24,
                                       1. / 120,
                                       1. / 720,
                                       1. / 5040,
                                       1. / 40320,
                                       1. / 362880,
                                       1. / 3628800,
                                       1. / 39916800,
                                       1. / 479001600,
                                       1. / 6227020800};
  const auto most = hn::Set(d, 709.782712893384), least = hn::Set(d, -745.2);
  const auto within = hn::Max(hn::Min(x, hn::Set(d, 710.0)), hn::Set(d, -746.0));
  const auto k = hn::Round(hn::Mul(within, hn::Set(d, 1.4426950408889634)));
  auto r = hn::Sub(within, hn::Mul(k, hn::Set(d, 6.93147180369123816490e-01)));
  r = hn::Sub(r, hn::Mul(k, hn::Set(d, 1.90821492927058770002e-10)));
  // Multiplies by 2^k in two steps, because 2^k may be below the smallest normal number.
  const auto half = hn::Floor(hn::Mul(k, hn::Set(d, 0.5)));
  auto value = hn::Mul(Polynomial(d, r, kSeries), PowerOfTwo(d, half));
  value = hn::Mul(value, PowerOfTwo(d, hn::Sub(k, half)));
  value =
      hn::IfThenElse(hn::Gt(x, most), hn::Set(d, std::numeric_limits<double>::infinity()), value);
  value = hn::IfThenElse(hn::Lt(x, least), hn::Zero(d), value);
  return hn::IfThenElse(hn::IsNaN(x), x, value);
}

template <class D>
HWY_INLINE V64<D> Ln(D d, V64<D> x) {
  static constexpr double kLg[] = {6.666666666666735130e-01, 3.999999999940941908e-01,
                                   2.857142874366239149e-01, 2.222219843214978396e-01,
                                   1.818357216161805012e-01, 1.531383769920937332e-01,
                                   1.479819860511658591e-01};
  const hn::RebindToSigned<D> di;
  const auto tiny = hn::Lt(x, hn::Set(d, 2.2250738585072014e-308));
  const auto scaled = hn::IfThenElse(tiny, hn::Mul(x, hn::Set(d, 0x1p54)), x);
  // Takes the exponent of x / sqrt(1/2), so that x / 2^exponent is between sqrt(1/2) and sqrt(2).
  const auto bits = hn::BitCast(di, scaled);
  const auto above = hn::Sub(bits, hn::Set(di, int64_t{0x3fe6a09e667f3bcd}));
  const auto exponent = hn::ShiftRight<52>(above);
  const auto rest = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<52>(exponent)));
  auto k = hn::ConvertTo(d, exponent);
  k = hn::Sub(k, hn::IfThenElseZero(tiny, hn::Set(d, 54.0)));
  const auto f = hn::Sub(rest, hn::Set(d, 1.0));
  const auto s = hn::Div(f, hn::Add(hn::Set(d, 2.0), f));
  const auto z = hn::Mul(s, s);
  const auto series = hn::Mul(z, Polynomial(d, z, kLg));
  const auto half = hn::Mul(hn::Mul(hn::Set(d, 0.5), f), f);
  const auto low = hn::Add(hn::Mul(s, hn::Add(half, series)),
                           hn::Mul(k, hn::Set(d, 1.90821492927058770002e-10)));
  auto value =
      hn::Sub(hn::Mul(k, hn::Set(d, 6.93147180369123816490e-01)), hn::Sub(hn::Sub(half, low), f));
  const auto infinity = hn::Set(d, std::numeric_limits<double>::infinity());
  value = hn::IfThenElse(hn::Eq(x, infinity), infinity, value);
  value = hn::IfThenElse(hn::Eq(x, hn::Zero(d)), hn::Neg(infinity), value);
  const auto nan = hn::Set(d, std::numeric_limits<double>::quiet_NaN());
  return hn::IfThenElse(hn::Or(hn::Lt(x, hn::Zero(d)), hn::IsNaN(x)), nan, value);
}

/// Computes sine and cosine. They are accurate to the last digits for |x| below 1e6.
template <class D>
HWY_INLINE void SinCos(D d, V64<D> x, V64<D>& sine, V64<D>& cosine) {
  static constexpr double kSine[] = {-1.66666666666666324348e-01, 8.33333333332248946124e-03,
                                     -1.98412698298579493134e-04, 2.75573137070700676789e-06,
                                     -2.50507602534068634195e-08, 1.58969099521155010221e-10};
  static constexpr double kCosine[] = {4.16666666666666019037e-02, -1.38888888888741095749e-03,
                                       2.48015872894767294178e-05, -2.75573143513906633035e-07,
                                       2.08757232129817482790e-09, -1.13596475577881948265e-11};
  const auto k = hn::Round(hn::Mul(x, hn::Set(d, 6.36619772367581382433e-01)));
  auto r = hn::Sub(x, hn::Mul(k, hn::Set(d, 1.57079632673412561417e+00)));
  r = hn::Sub(r, hn::Mul(k, hn::Set(d, 6.07710050630396597660e-11)));
  r = hn::Sub(r, hn::Mul(k, hn::Set(d, 2.02226624871116645580e-21)));
  const auto z = hn::Mul(r, r);
  const auto s = hn::Add(r, hn::Mul(hn::Mul(r, z), Polynomial(d, z, kSine)));
  const auto half = hn::Mul(hn::Set(d, 0.5), z);
  const auto one = hn::Set(d, 1.0);
  const auto w = hn::Sub(one, half);
  const auto c = hn::Add(w, hn::Add(hn::Sub(hn::Sub(one, w), half),
                                    hn::Mul(hn::Mul(z, z), Polynomial(d, z, kCosine))));
  // The quadrant, from 0 to 3.
  const auto quadrant =
      hn::Sub(k, hn::Mul(hn::Set(d, 4.0), hn::Floor(hn::Mul(k, hn::Set(d, 0.25)))));
  const auto two = hn::Set(d, 2.0);
  const auto odd = hn::Or(hn::Eq(quadrant, one), hn::Eq(quadrant, hn::Set(d, 3.0)));
  const auto plain_sine = hn::IfThenElse(odd, c, s), plain_cosine = hn::IfThenElse(odd, s, c);
  sine = hn::IfThenElse(hn::Ge(quadrant, two), hn::Neg(plain_sine), plain_sine);
  const auto negative = hn::Or(hn::Eq(quadrant, one), hn::Eq(quadrant, two));
  cosine = hn::IfThenElse(negative, hn::Neg(plain_cosine), plain_cosine);
}

/// Returns the arc tangent of x >= 0.
template <class D>
HWY_INLINE V64<D> AtanOfPositive(D d, V64<D> x) {
  static constexpr double kAt[] = {
      3.33333333333329318027e-01,  -1.99999999998764832476e-01, 1.42857142725034663711e-01,
      -1.11111104054623557880e-01, 9.09088713343650656196e-02,  -7.69187620504482999495e-02,
      6.66107313738753120669e-02,  -5.83357013379057348645e-02, 4.97687799461593236017e-02,
      -3.65315727442169155270e-02, 1.62858201153657823623e-02};
  const auto one = hn::Set(d, 1.0), two = hn::Set(d, 2.0), half = hn::Set(d, 0.5),
             more = hn::Set(d, 1.5);
  const auto from = [&](double at) { return hn::Ge(x, hn::Set(d, at)); };
  const auto above1 = from(7.0 / 16), above2 = from(11.0 / 16), above3 = from(19.0 / 16),
             above4 = from(39.0 / 16);
  auto over = x, under = one, high = hn::Zero(d), low = high;
  const auto take = [&](auto mask, auto numerator, auto denominator, double h, double l) {
    over = hn::IfThenElse(mask, numerator, over);
    under = hn::IfThenElse(mask, denominator, under);
    high = hn::IfThenElse(mask, hn::Set(d, h), high);
    low = hn::IfThenElse(mask, hn::Set(d, l), low);
  };
  take(above1, hn::Sub(hn::Mul(two, x), one), hn::Add(two, x), 4.63647609000806093515e-01,
       2.26987774529616870924e-17);
  take(above2, hn::Sub(x, one), hn::Add(x, one), 7.85398163397448278999e-01,
       3.06161699786838301793e-17);
  take(above3, hn::Sub(x, more), hn::Add(one, hn::Mul(more, x)), 9.82793723247329054082e-01,
       1.39033110312309984516e-17);
  take(above4, hn::Set(d, -1.0), x, 1.57079632679489655800e+00, 6.12323399573676603587e-17);
  (void)half;
  const auto t = hn::Div(over, under);
  const auto z = hn::Mul(t, t);
  const auto series = hn::Mul(hn::Mul(t, z), Polynomial(d, z, kAt));
  return hn::Sub(high, hn::Sub(hn::Sub(series, low), t));
}

template <class D>
HWY_INLINE V64<D> Atan(D d, V64<D> x) {
  return hn::CopySign(AtanOfPositive(d, hn::Abs(x)), x);
}

template <class D>
HWY_INLINE V64<D> Atan2(D d, V64<D> y, V64<D> x) {
  const auto zero = hn::Zero(d);
  const auto far = hn::Abs(y), near = hn::Abs(x);
  const auto steep = hn::Gt(far, near);
  const auto larger = hn::Max(far, near), smaller = hn::Min(far, near);
  // NaN is handled separately, because Max and Min of NaN differ between instruction sets.
  const auto nan = hn::Or(hn::IsNaN(x), hn::IsNaN(y));
  const auto ratio = hn::IfThenElse(hn::Eq(larger, zero), zero, hn::Div(smaller, larger));
  auto angle = AtanOfPositive(d, ratio);
  angle = hn::IfThenElse(steep, hn::Sub(hn::Set(d, 1.5707963267948966), angle), angle);
  angle = hn::IfThenElse(hn::Lt(x, zero), hn::Sub(hn::Set(d, 3.141592653589793), angle), angle);
  angle = hn::IfThenElse(nan, hn::Set(d, std::numeric_limits<double>::quiet_NaN()), angle);
  return hn::CopySign(angle, y);
}

template <class D>
HWY_INLINE V64<D> Tanh(D d, V64<D> x) {
  static constexpr double kSeries[] = {1,
                                       -1. / 3,
                                       2. / 15,
                                       -17. / 315,
                                       62. / 2835,
                                       -1382. / 155925,
                                       21844. / 6081075,
                                       -929569. / 638512875,
                                       6404582. / 10854718875.,
                                       -443861162. / 1856156927625.};
  const auto size = hn::Abs(x), one = hn::Set(d, 1.0), two = hn::Set(d, 2.0);
  const auto z = hn::Mul(x, x);
  const auto small = hn::Mul(size, Polynomial(d, z, kSeries));
  const auto grown = Exp(d, hn::Mul(two, hn::Min(size, hn::Set(d, 40.0))));
  const auto large = hn::Sub(one, hn::Div(two, hn::Add(grown, one)));
  const auto value = hn::IfThenElse(hn::Lt(size, hn::Set(d, 0.15)), small, large);
  return hn::IfThenElse(hn::IsNaN(x), x, hn::CopySign(value, x));
}

/// Computes a^b. For a negative base, the exponent must be a whole number.
template <class D>
HWY_INLINE V64<D> Pow(D d, V64<D> a, V64<D> b) {
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0);
  const auto infinity = hn::Set(d, std::numeric_limits<double>::infinity());
  const auto nan = hn::Set(d, std::numeric_limits<double>::quiet_NaN());
  auto value = Exp(d, hn::Mul(b, Ln(d, hn::Abs(a))));
  const auto whole = hn::Eq(b, hn::Floor(b));
  const auto half = hn::Mul(b, hn::Set(d, 0.5));
  const auto odd = hn::And(whole, hn::Not(hn::Eq(half, hn::Floor(half))));
  const auto negative = hn::Lt(a, zero);
  value = hn::IfThenElse(hn::And(negative, odd), hn::Neg(value), value);
  value = hn::IfThenElse(hn::AndNot(whole, negative), nan, value);
  value = hn::IfThenElse(hn::Eq(a, zero), hn::IfThenElse(hn::Lt(b, zero), infinity, zero), value);
  value = hn::IfThenElse(hn::Or(hn::IsNaN(a), hn::IsNaN(b)), nan, value);
  return hn::IfThenElse(hn::Eq(b, zero), one, value);
}

}  // namespace HWY_NAMESPACE
}  // namespace vesper::text
HWY_AFTER_NAMESPACE();
#endif
