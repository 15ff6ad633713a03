// SPDX-License-Identifier: Apache-2.0
// Numbers side by side in a register of the processor, for the solution of several contacts at
// once.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace vesper::rigid {

/** A truth value in each lane. */
template <class Real>
struct LaneMask {
  using Bits = std::conditional_t<sizeof(Real) == 4, int32_t, int64_t>;
  typedef Bits Register __attribute__((vector_size(16)));
  typedef int64_t Halves __attribute__((vector_size(16)));

  Register bits;  // all bits of a lane are equal

  friend LaneMask operator&(LaneMask a, LaneMask b) { return {a.bits & b.bits}; }
  /** Returns whether the mask is true in at least one lane. */
  friend bool Any(LaneMask mask) {
    const Halves halves = reinterpret_cast<Halves>(mask.bits);
    return (halves[0] | halves[1]) != 0;
  }
};

/** As many numbers as a register of 16 bytes contains, one in each lane. An operation acts on every
 *  lane, and its results have the bits of the same operation on single numbers. */
template <class Real>
class Lanes {
 public:
  static constexpr int kCount = 16 / sizeof(Real);
  using Mask = LaneMask<Real>;

  Lanes() = default;
  /** Sets all lanes to the same number. */
  Lanes(Real number) {
    for (int lane = 0; lane < kCount; ++lane) numbers_[lane] = number;
  }

  /** Reads as many numbers as there are lanes, from the address `from`. */
  static Lanes Load(const Real* from) {
    Lanes lanes;
    std::memcpy(&lanes.numbers_, from, sizeof lanes.numbers_);
    return lanes;
  }

  /** Reads kCount numbers at each of kCount addresses. Lane l of the k-th result is the k-th number
   *  at the l-th address. */
  static std::array<Lanes, kCount> LoadColumns(const std::array<const Real*, kCount>& rows) {
    std::array<Lanes, kCount> columns;
    for (int row = 0; row < kCount; ++row) columns[row] = Load(rows[row]);
    Transpose(columns);
    return columns;
  }
  /** Writes numbers where LoadColumns reads them. */
  static void StoreColumns(std::array<Lanes, kCount> columns,
                           const std::array<Real*, kCount>& rows) {
    Transpose(columns);
    for (int row = 0; row < kCount; ++row) {
      std::memcpy(rows[row], &columns[row].numbers_, sizeof columns[row].numbers_);
    }
  }

  Real operator[](int lane) const { return numbers_[lane]; }
  void Set(int lane, Real number) { numbers_[lane] = number; }

  friend Lanes operator+(Lanes a, Lanes b) { return Of(a.numbers_ + b.numbers_); }
  friend Lanes operator-(Lanes a, Lanes b) { return Of(a.numbers_ - b.numbers_); }
  friend Lanes operator*(Lanes a, Lanes b) { return Of(a.numbers_ * b.numbers_); }
  friend Lanes operator/(Lanes a, Lanes b) { return Of(a.numbers_ / b.numbers_); }
  friend Lanes operator-(Lanes a) { return Of(-a.numbers_); }
  friend Lanes& operator+=(Lanes& a, Lanes b) { return a = a + b; }
  friend Mask operator<(Lanes a, Lanes b) { return {a.numbers_ < b.numbers_}; }
  friend Mask operator>(Lanes a, Lanes b) { return {a.numbers_ > b.numbers_}; }
  friend Mask operator<=(Lanes a, Lanes b) { return {a.numbers_ <= b.numbers_}; }

  /** Returns in each lane the number of `a` where the mask is true, and of `b` elsewhere. */
  friend Lanes Select(Mask mask, Lanes a, Lanes b) {
    return Of(mask.bits ? a.numbers_ : b.numbers_);
  }
  friend Lanes Sqrt(Lanes a) {
    for (int lane = 0; lane < kCount; ++lane) a.numbers_[lane] = std::sqrt(a.numbers_[lane]);
    return a;
  }

 private:
  typedef Real Register __attribute__((vector_size(16)));

  static Lanes Of(Register numbers) {
    Lanes lanes;
    lanes.numbers_ = numbers;
    return lanes;
  }

  /** Exchanges the rows and columns of a square of numbers. */
  static void Transpose(std::array<Lanes, kCount>& rows) {
    if constexpr (kCount == 2) {
      const Register p = rows[0].numbers_, q = rows[1].numbers_;
      rows[0].numbers_ = __builtin_shufflevector(p, q, 0, 2);
      rows[1].numbers_ = __builtin_shufflevector(p, q, 1, 3);
    } else {
      const Register p = rows[0].numbers_, q = rows[1].numbers_;
      const Register r = rows[2].numbers_, s = rows[3].numbers_;
      const Register a = __builtin_shufflevector(p, q, 0, 4, 1, 5);
      const Register b = __builtin_shufflevector(r, s, 0, 4, 1, 5);
      const Register c = __builtin_shufflevector(p, q, 2, 6, 3, 7);
      const Register d = __builtin_shufflevector(r, s, 2, 6, 3, 7);
      rows[0].numbers_ = __builtin_shufflevector(a, b, 0, 1, 4, 5);
      rows[1].numbers_ = __builtin_shufflevector(a, b, 2, 3, 6, 7);
      rows[2].numbers_ = __builtin_shufflevector(c, d, 0, 1, 4, 5);
      rows[3].numbers_ = __builtin_shufflevector(c, d, 2, 3, 6, 7);
    }
  }

  Register numbers_{};
};

// The same functions for single numbers.

template <std::floating_point Real>
Real Select(bool condition, Real a, Real b) {
  return condition ? a : b;
}
template <std::floating_point Real>
Real Sqrt(Real a) {
  return std::sqrt(a);
}
inline bool Any(bool condition) { return condition; }

/** Return the larger or the smaller one of two numbers, in each lane. They return `a` where the
 *  numbers are equal, as std::max and std::min do. */
template <class Number>
Number Larger(Number a, Number b) {
  return Select(a < b, b, a);
}
template <class Number>
Number Smaller(Number a, Number b) {
  return Select(b < a, b, a);
}

}  // namespace vesper::rigid
