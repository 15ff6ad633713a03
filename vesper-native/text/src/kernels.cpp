// SPDX-License-Identifier: Apache-2.0
// Highway includes this file once for each instruction set.
#include "kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

// On x86 the remaining targets are the baseline, AVX2 and AVX-512.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels.cpp"
#include "hwy/foreach_target.h"
#include "hwy/highway.h"

#include "elementary-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace vesper::text {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class Real>
using Lanes = hn::CappedTag<Real, 16>;

/// An operand: a block of values, or one value for all rows.
template <class Real>
struct Block {
  const Real* values;
  HWY_INLINE auto operator()(Lanes<Real> d, size_t i) const { return hn::LoadU(d, values + i); }
};
template <class Real>
struct Same {
  hn::Vec<Lanes<Real>> value;
  HWY_INLINE auto operator()(Lanes<Real>, size_t) const { return value; }
};

template <class Real, class Body>
HWY_INLINE void Each(size_t count, Real* to, Body&& body) {
  const Lanes<Real> d;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) hn::StoreU(body(d, i), d, to + i);
}

template <class Real>
struct Operands {
  Real* const* registers;
  const Real* uniforms;

  bool IsUniform(uint16_t operand) const { return operand >= kUniform; }
  Block<Real> Values(uint16_t operand) const { return {registers[operand]}; }
  Same<Real> One(uint16_t operand) const {
    return {hn::Set(Lanes<Real>(), uniforms[operand - kUniform])};
  }
  /// Calls `body` with the operands as blocks or single values. At least one operand is a block.
  template <class Body>
  HWY_INLINE void Two(uint16_t a, uint16_t b, Body&& body) const {
    if (IsUniform(a)) {
      body(One(a), Values(b));
    } else if (IsUniform(b)) {
      body(Values(a), One(b));
    } else {
      body(Values(a), Values(b));
    }
  }
};

template <class Real, class Function>
HWY_INLINE void Binary(const Operands<Real>& all, const Instruction& step, size_t count,
                       Function&& function) {
  Real* to = all.registers[step.to];
  all.Two(step.a, step.b, [&](auto a, auto b) {
    Each(count, to, [&](auto d, size_t i) { return function(d, a(d, i), b(d, i)); });
  });
}

template <class Real, class Function>
HWY_INLINE void Unary(const Operands<Real>& all, const Instruction& step, size_t count,
                      Function&& function) {
  const Block<Real> a = all.Values(step.a);
  Each(count, all.registers[step.to], [&](auto d, size_t i) { return function(d, a(d, i)); });
}

template <class D, class M>
HWY_INLINE hn::Vec<D> Truth(D d, M mask) {
  return hn::IfThenElseZero(mask, hn::Set(d, hn::TFromD<D>(1)));
}

template <class Real>
HWY_INLINE void Select(const Operands<Real>& all, const Instruction& step, size_t count) {
  Real* to = all.registers[step.to];
  const auto choose = [&](auto condition, auto b, auto c) {
    Each(count, to, [&](auto d, size_t i) {
      return hn::IfThenElse(hn::Eq(condition(d, i), hn::Zero(d)), c(d, i), b(d, i));
    });
  };
  const auto with = [&](auto condition) {
    if (all.IsUniform(step.b) && all.IsUniform(step.c)) {
      choose(condition, all.One(step.b), all.One(step.c));
    } else {
      all.Two(step.b, step.c, [&](auto b, auto c) { choose(condition, b, c); });
    }
  };
  if (all.IsUniform(step.a)) {
    with(all.One(step.a));
  } else {
    with(all.Values(step.a));
  }
}

/// Applies a function on doubles to values of any precision.
template <class Real, class Function>
HWY_INLINE void InDouble(const Operands<Real>& all, const Instruction& step, size_t count,
                         Function&& function) {
  Real* to = all.registers[step.to];
  const hn::CappedTag<double, 8> d;
  const size_t lanes = hn::Lanes(d);
  const auto load = [&](uint16_t operand, size_t i) {
    if (all.IsUniform(operand)) {
      return hn::Set(d, static_cast<double>(all.uniforms[operand - kUniform]));
    }
    if constexpr (sizeof(Real) == sizeof(double)) {
      return hn::LoadU(d, all.registers[operand] + i);
    } else {
      const hn::Rebind<Real, decltype(d)> narrow;
      return hn::PromoteTo(d, hn::LoadU(narrow, all.registers[operand] + i));
    }
  };
  for (size_t i = 0; i < count; i += lanes) {
    const auto a = load(step.a, i);
    const auto b = step.b == 0xffff ? hn::Zero(d) : load(step.b, i);
    const auto value = function(d, a, b);
    if constexpr (sizeof(Real) == sizeof(double)) {
      hn::StoreU(value, d, to + i);
    } else {
      // Converts values one by one, because DemoteTo of some instruction sets replaces infinity by
      // the largest number.
      HWY_ALIGN double values[8];
      hn::Store(value, d, values);
      for (size_t k = 0; k < lanes; ++k) to[i + k] = static_cast<Real>(values[k]);
    }
  }
}

template <class D>
HWY_INLINE V64<D> OfDoubles(D d, Operation operation, V64<D> a, V64<D> b) {
  V64<D> sine, cosine;
  switch (operation) {
    case Operation::kExp:
      return Exp(d, a);
    case Operation::kLn:
      return Ln(d, a);
    case Operation::kSin:
      SinCos(d, a, sine, cosine);
      return sine;
    case Operation::kCos:
      SinCos(d, a, sine, cosine);
      return cosine;
    case Operation::kTan:
      SinCos(d, a, sine, cosine);
      return hn::Div(sine, cosine);
    case Operation::kAsin:
    case Operation::kAcos: {
      const auto one = hn::Set(d, 1.0);
      const auto other = hn::Sqrt(hn::Mul(hn::Sub(one, a), hn::Add(one, a)));
      return operation == Operation::kAsin ? Atan2(d, a, other) : Atan2(d, other, a);
    }
    case Operation::kAtan:
      return Atan(d, a);
    case Operation::kAtan2:
      return Atan2(d, a, b);
    case Operation::kTanh:
      return Tanh(d, a);
    default:
      return Pow(d, a, b);
  }
}

template <class Real>
void Run(std::span<const Instruction> program, Real* const* registers, const Real* uniforms,
         size_t count) {
  const Operands<Real> all{registers, uniforms};
  for (const Instruction& step : program) {
    switch (step.operation) {
      case Operation::kAdd:
        Binary(all, step, count, [](auto, auto a, auto b) { return hn::Add(a, b); });
        break;
      case Operation::kSubtract:
        Binary(all, step, count, [](auto, auto a, auto b) { return hn::Sub(a, b); });
        break;
      case Operation::kMultiply:
        Binary(all, step, count, [](auto, auto a, auto b) { return hn::Mul(a, b); });
        break;
      case Operation::kDivide:
        Binary(all, step, count, [](auto, auto a, auto b) { return hn::Div(a, b); });
        break;
      case Operation::kNegate:
        Unary(all, step, count, [](auto, auto a) { return hn::Neg(a); });
        break;
      case Operation::kSqrt:
        Unary(all, step, count, [](auto, auto a) { return hn::Sqrt(a); });
        break;
      case Operation::kAbs:
        Unary(all, step, count, [](auto, auto a) { return hn::Abs(a); });
        break;
      case Operation::kFloor:
        // Adding 0 turns -0 into +0. Floor does so on some instruction sets only, but all sets must
        // give the same bits.
        Unary(all, step, count, [](auto d, auto a) { return hn::Add(hn::Floor(a), hn::Zero(d)); });
        break;
      case Operation::kMin:
        Binary(all, step, count,
               [](auto, auto a, auto b) { return hn::IfThenElse(hn::Lt(b, a), b, a); });
        break;
      case Operation::kMax:
        Binary(all, step, count,
               [](auto, auto a, auto b) { return hn::IfThenElse(hn::Lt(a, b), b, a); });
        break;
      case Operation::kLess:
        Binary(all, step, count, [](auto d, auto a, auto b) { return Truth(d, hn::Lt(a, b)); });
        break;
      case Operation::kLessOrEqual:
        Binary(all, step, count, [](auto d, auto a, auto b) { return Truth(d, hn::Le(a, b)); });
        break;
      case Operation::kEqual:
        Binary(all, step, count, [](auto d, auto a, auto b) { return Truth(d, hn::Eq(a, b)); });
        break;
      case Operation::kAnd:
        Binary(all, step, count, [](auto d, auto a, auto b) {
          return Truth(d, hn::Not(hn::Or(hn::Eq(a, hn::Zero(d)), hn::Eq(b, hn::Zero(d)))));
        });
        break;
      case Operation::kOr:
        Binary(all, step, count, [](auto d, auto a, auto b) {
          return Truth(d, hn::Not(hn::And(hn::Eq(a, hn::Zero(d)), hn::Eq(b, hn::Zero(d)))));
        });
        break;
      case Operation::kNot:
        Unary(all, step, count, [](auto d, auto a) { return Truth(d, hn::Eq(a, hn::Zero(d))); });
        break;
      case Operation::kSelect:
        Select(all, step, count);
        break;
      default:
        InDouble(all, step, count,
                 [&](auto d, auto a, auto b) { return OfDoubles(d, step.operation, a, b); });
        break;
    }
  }
}

template <class Real>
void Function(Operation operation, const Real* a, const Real* b, Real* to) {
  Real* const registers[] = {const_cast<Real*>(a), const_cast<Real*>(b), to};
  const Instruction step{operation, 2, 0, 1, 0xffff};
  InDouble(Operands<Real>{registers, nullptr}, step, hn::Lanes(Lanes<Real>()),
           [&](auto d, auto left, auto right) { return OfDoubles(d, operation, left, right); });
}

template <class Real>
void Split3(const Real* rows, size_t count, Real* x, Real* y, Real* z) {
  const Lanes<Real> d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::Vec<Lanes<Real>> vx, vy, vz;
    hn::LoadInterleaved3(d, rows + 3 * i, vx, vy, vz);
    hn::StoreU(vx, d, x + i);
    hn::StoreU(vy, d, y + i);
    hn::StoreU(vz, d, z + i);
  }
  for (; i < count; ++i) {
    x[i] = rows[3 * i];
    y[i] = rows[3 * i + 1];
    z[i] = rows[3 * i + 2];
  }
}

inline void SplitRowNumbers(const uint32_t* pairs, size_t count, uint32_t* first,
                            uint32_t* second) {
  const hn::ScalableTag<uint32_t> d;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::Vec<decltype(d)> a, b;
    hn::LoadInterleaved2(d, pairs + 2 * i, a, b);
    hn::StoreU(a, d, first + i);
    hn::StoreU(b, d, second + i);
  }
  for (; i < count; ++i) {
    first[i] = pairs[2 * i];
    second[i] = pairs[2 * i + 1];
  }
}

/// Detects values that are not finite: the difference of such a value from itself is NaN.
template <class Real>
struct Watch {
  hn::Vec<Lanes<Real>> difference;
  bool finite = true;

  // The constructor is written explicitly, because the compiler would compile an implicit
  // constructor for the baseline instruction set.
  HWY_INLINE Watch() : difference(hn::Zero(Lanes<Real>())) {}
  HWY_INLINE hn::Vec<Lanes<Real>> See(hn::Vec<Lanes<Real>> value) {
    difference = hn::Add(difference, hn::Sub(value, value));
    return value;
  }
  HWY_INLINE Real See(Real value) {
    finite = finite && std::isfinite(value);
    return value;
  }
  HWY_INLINE bool AllFinite() const {
    const Lanes<Real> d;
    return finite && hn::AllTrue(d, hn::Eq(difference, hn::Zero(d)));
  }
};

template <class Real>
bool Join3(Real* rows, size_t count, const Real* x, const Real* y, const Real* z) {
  const Lanes<Real> d;
  const size_t lanes = hn::Lanes(d);
  Watch<Real> watch;
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreInterleaved3(watch.See(hn::LoadU(d, x + i)), watch.See(hn::LoadU(d, y + i)),
                          watch.See(hn::LoadU(d, z + i)), d, rows + 3 * i);
  }
  for (; i < count; ++i) {
    rows[3 * i] = watch.See(x[i]);
    rows[3 * i + 1] = watch.See(y[i]);
    rows[3 * i + 2] = watch.See(z[i]);
  }
  return watch.AllFinite();
}

template <class Real>
bool Add3(Real* rows, size_t count, const Real* x, const Real* y, const Real* z) {
  const Lanes<Real> d;
  const size_t lanes = hn::Lanes(d);
  Watch<Real> watch;
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::Vec<Lanes<Real>> vx, vy, vz;
    hn::LoadInterleaved3(d, rows + 3 * i, vx, vy, vz);
    hn::StoreInterleaved3(watch.See(hn::Add(vx, hn::LoadU(d, x + i))),
                          watch.See(hn::Add(vy, hn::LoadU(d, y + i))),
                          watch.See(hn::Add(vz, hn::LoadU(d, z + i))), d, rows + 3 * i);
  }
  for (; i < count; ++i) {
    rows[3 * i] = watch.See(rows[3 * i] + x[i]);
    rows[3 * i + 1] = watch.See(rows[3 * i + 1] + y[i]);
    rows[3 * i + 2] = watch.See(rows[3 * i + 2] + z[i]);
  }
  return watch.AllFinite();
}

template <class Real>
bool Add1(Real* rows, size_t count, const Real* x) {
  const Lanes<Real> d;
  const size_t lanes = hn::Lanes(d);
  Watch<Real> watch;
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    hn::StoreU(watch.See(hn::Add(hn::LoadU(d, rows + i), hn::LoadU(d, x + i))), d, rows + i);
  }
  for (; i < count; ++i) rows[i] = watch.See(rows[i] + x[i]);
  return watch.AllFinite();
}

template <class Real>
void Add3At(Real* column, const uint32_t* rows, size_t count, const Real* x, const Real* y,
            const Real* z) {
  HWY_ALIGN Real joined[3 * kBlock];
  Join3(joined, count, x, y, z);
  // Two values at once and the third alone: a load of four could overlap a store of the row before.
  const hn::CappedTag<Real, 2> two;
  for (size_t i = 0; i < count; ++i) {
    Real* to = column + 3 * uint64_t{rows[i]};
    const Real* from = joined + 3 * i;
    for (size_t k = 0; k < 2; k += hn::Lanes(two)) {
      hn::StoreU(hn::Add(hn::LoadU(two, to + k), hn::LoadU(two, from + k)), two, to + k);
    }
    to[2] += from[2];
  }
}

template <class Real>
Real Sum(Real* values, size_t count) {
  constexpr size_t kLanes = 16;  // number of partial sums; the same for all instruction sets, so
                                 // that sums have the same bits
  const Lanes<Real> d;
  const size_t lanes = hn::Lanes(d);
  const size_t padded = (count + kLanes - 1) / kLanes * kLanes;
  std::fill(values + count, values + padded, Real(0));
  HWY_ALIGN Real sums[kLanes] = {};
  for (size_t lane = 0; lane < kLanes; lane += lanes) {
    auto sum = hn::Zero(d);
    for (size_t i = lane; i < padded; i += kLanes) sum = hn::Add(sum, hn::LoadU(d, values + i));
    hn::StoreU(sum, d, sums + lane);
  }
  for (size_t half = kLanes / 2; half > 0; half /= 2) {
    for (size_t i = 0; i < half; ++i) sums[i] += sums[i + half];
  }
  return sums[0];
}

template <class Real>
bool Finite(const Real* values, size_t count) {
  const Lanes<Real> d;
  const size_t lanes = hn::Lanes(d);
  Watch<Real> watch;
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) watch.See(hn::LoadU(d, values + i));
  for (; i < count; ++i) watch.See(values[i]);
  return watch.AllFinite();
}

template <class Real>
Kernels<Real> All(const char* name, InstructionSet set) {
  return {name,        set,        Run<Real>,  Function<Real>, Split3<Real>, SplitRowNumbers,
          Join3<Real>, Add3<Real>, Add1<Real>, Add3At<Real>,   Sum<Real>,    Finite<Real>};
}

Kernels<float> AllF32(const char* name, InstructionSet set) { return All<float>(name, set); }
Kernels<double> AllF64(const char* name, InstructionSet set) { return All<double>(name, set); }

double ElementaryOnOne(Operation operation, double a, double b) {
  const hn::CappedTag<double, 1> d;
  return hn::GetLane(OfDoubles(d, operation, hn::Set(d, a), hn::Set(d, b)));
}

}  // namespace HWY_NAMESPACE
}  // namespace vesper::text
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vesper::text {
namespace {

#if HWY_ARCH_X86_64
#define VESPER_TEXT_SETS(function)                                                           \
  std::vector sets{HWY_STATIC_DISPATCH(function)("baseline", InstructionSet::kBaseline)};    \
  if (HasAvx2()) sets.insert(sets.begin(), N_AVX2::function("AVX2", InstructionSet::kAvx2)); \
  if (HasAvx2() && HasAvx512()) {                                                            \
    sets.insert(sets.begin(), N_AVX3::function("AVX-512", InstructionSet::kAvx512));         \
  }                                                                                          \
  return sets

// These are the features of Highway's two targets. The compiler's test also checks whether the
// operating system supports them.
bool HasAvx2() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
         __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("f16c") &&
         __builtin_cpu_supports("aes") && __builtin_cpu_supports("pclmul");
}
bool HasAvx512() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}
#else
#define VESPER_TEXT_SETS(function) \
  return std::vector { HWY_STATIC_DISPATCH(function)("baseline", InstructionSet::kBaseline) }
#endif

std::vector<Kernels<float>> FindF32() { VESPER_TEXT_SETS(AllF32); }
std::vector<Kernels<double>> FindF64() { VESPER_TEXT_SETS(AllF64); }

}  // namespace

template <>
const std::vector<Kernels<float>>& AvailableKernels<float>() {
  static const std::vector<Kernels<float>> sets = FindF32();
  return sets;
}

template <>
const std::vector<Kernels<double>>& AvailableKernels<double>() {
  static const std::vector<Kernels<double>> sets = FindF64();
  return sets;
}

double Elementary(Operation operation, double a, double b) {
  return HWY_STATIC_DISPATCH(ElementaryOnOne)(operation, a, b);
}

template <class Real>
Real ComputeIn(Operation operation, Real a, Real b, Real c) {
  switch (operation) {
    case Operation::kAdd:
      return a + b;
    case Operation::kSubtract:
      return a - b;
    case Operation::kMultiply:
      return a * b;
    case Operation::kDivide:
      return a / b;
    case Operation::kNegate:
      return -a;
    case Operation::kSqrt:
      return std::sqrt(a);
    case Operation::kAbs:
      return std::abs(a);
    case Operation::kMin:
      return b < a ? b : a;
    case Operation::kMax:
      return a < b ? b : a;
    case Operation::kFloor:
      return std::floor(a) + Real(0);
    case Operation::kLess:
      return a < b ? Real(1) : Real(0);
    case Operation::kLessOrEqual:
      return a <= b ? Real(1) : Real(0);
    case Operation::kEqual:
      return a == b ? Real(1) : Real(0);
    case Operation::kAnd:
      return a != 0 && b != 0 ? Real(1) : Real(0);
    case Operation::kOr:
      return a != 0 || b != 0 ? Real(1) : Real(0);
    case Operation::kNot:
      return a != 0 ? Real(0) : Real(1);
    case Operation::kSelect:
      return a != 0 ? b : c;
    default:
      return static_cast<Real>(Elementary(operation, a, b));
  }
}

template float ComputeIn(Operation, float, float, float);
template double ComputeIn(Operation, double, double, double);

}  // namespace vesper::text
#endif  // HWY_ONCE
