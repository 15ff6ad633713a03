// SPDX-License-Identifier: Apache-2.0
// Floating-point modes for calls of foreign code.
#pragma once

#include <cfenv>
#include <cstdint>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace vesper {

/// Sets the default floating-point modes (round to nearest, no traps, no flushing) and restores the
/// caller's modes at destruction. Therefore laws compute the same bits in every program, and cannot
/// change the program's arithmetic.
class FloatingPointGuard {
 public:
  FloatingPointGuard(const FloatingPointGuard&) = delete;
  FloatingPointGuard& operator=(const FloatingPointGuard&) = delete;

#if defined(__x86_64__)
  FloatingPointGuard() : mxcsr_(_mm_getcsr()) {
    asm volatile("fnstcw %0" : "=m"(x87_));
    SetX87(kDefaultX87);
    _mm_setcsr(kDefaultMxcsr);
  }
  ~FloatingPointGuard() {
    SetX87(x87_);
    _mm_setcsr(mxcsr_);
  }

 private:
  static constexpr uint32_t kDefaultMxcsr = 0x1f80;
  static constexpr uint16_t kDefaultX87 = 0x037f;

  static void SetX87(uint16_t word) { asm volatile("fnclex\n\tfldcw %0" : : "m"(word)); }

  uint32_t mxcsr_;
  uint16_t x87_;
#else
  FloatingPointGuard() {
    std::fegetenv(&environment_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~FloatingPointGuard() { std::fesetenv(&environment_); }

 private:
  std::fenv_t environment_;
#endif
};

}  // namespace vesper
