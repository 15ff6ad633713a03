// SPDX-License-Identifier: Apache-2.0
// The fastest loop over damped springs for one type of processor that the authors know. It uses
// AVX-512 with approximate reciprocal roots, for eight springs at a time, and OpenMP with a buffer
// of forces for each thread. It is the reference for the law. Its bits depend on the processor and
// on the number of threads.
#pragma once

#include <immintrin.h>
#include <omp.h>

#include <array>
#include <cstdint>
#include <vector>

namespace bench {

/// Bodies of four numbers, of which three are used, and springs between them.
class SpringsKernel {
 public:
  struct alignas(16) Body {
    float value[4];
  };

  SpringsKernel(const std::vector<float>& mass, const std::vector<float>& position,
                const std::vector<std::array<uint32_t, 2>>& ends, const std::vector<float>& length,
                float hooke, float damping, int threads)
      : threads_(threads),
        velocity_(mass.size(), Body{}),
        length_(length),
        hooke_(ends.size(), hooke),
        damping_(ends.size(), damping),
        force_(threads, std::vector<Body>(mass.size(), Body{})) {
    for (uint64_t i = 0; i < mass.size(); ++i) {
      position_.push_back({{position[3 * i], position[3 * i + 1], position[3 * i + 2], 0}});
      inverse_mass_.push_back(1 / mass[i]);
    }
    for (const auto& [a, b] : ends) {
      first_.push_back(a);
      second_.push_back(b);
    }
  }

  /// Runs this number of steps of semi-implicit Euler.
  void Advance(float dt, int steps) {
#pragma omp parallel num_threads(threads_)
    {
      const uint64_t t = omp_get_thread_num();
      const auto part = [&](uint64_t count, uint64_t i) { return count * i / threads_ / 8 * 8; };
      const uint64_t bodies = position_.size(), springs = first_.size();
      const bool last = t + 1 == static_cast<uint64_t>(threads_);
      for (int step = 0; step < steps; ++step) {
        Pull(force_[t].data()->value, part(springs, t), last ? springs : part(springs, t + 1));
#pragma omp barrier
        Move(part(bodies, t), last ? bodies : part(bodies, t + 1), dt);
#pragma omp barrier
      }
    }
  }

  const std::vector<Body>& position() const { return position_; }

 private:
  /// Loads the k-th and the (k + 4)-th body.
  static __m256 Two(const float* values, const uint32_t* bodies, int k) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(values + 4 * bodies[k])),
                                _mm_load_ps(values + 4 * bodies[k + 4]), 1);
  }
  /// Returns the dot products of eight pairs of vectors.
  static __m256 Dot(const __m256* a, const __m256* b) {
    return _mm256_hadd_ps(_mm256_hadd_ps(_mm256_mul_ps(a[0], b[0]), _mm256_mul_ps(a[1], b[1])),
                          _mm256_hadd_ps(_mm256_mul_ps(a[2], b[2]), _mm256_mul_ps(a[3], b[3])));
  }

  void Pull(float* force, uint64_t begin, uint64_t end) const {
    uint64_t s = begin;
    for (; s + 8 <= end; s += 8) {
      const uint32_t *a = &first_[s], *b = &second_[s];
      const float *p = position_.data()->value, *v = velocity_.data()->value;
      __m256 d[4], u[4];
#pragma GCC unroll 4
      for (int k = 0; k < 4; ++k) {
        d[k] = _mm256_sub_ps(Two(p, b, k), Two(p, a, k));
        u[k] = _mm256_sub_ps(Two(v, b, k), Two(v, a, k));
      }
      const __m256 r2 = Dot(d, d), du = Dot(d, u);
      __m256 inverse = _mm256_rsqrt14_ps(r2);
      const __m256 error = _mm256_fnmadd_ps(_mm256_mul_ps(r2, inverse), inverse, _mm256_set1_ps(1));
      inverse = _mm256_fmadd_ps(_mm256_mul_ps(inverse, error), _mm256_set1_ps(0.5f), inverse);
      const __m256 strain = _mm256_fmsub_ps(r2, inverse, _mm256_loadu_ps(&length_[s]));
      const __m256 damped =
          _mm256_mul_ps(_mm256_loadu_ps(&damping_[s]), _mm256_mul_ps(du, inverse));
      const __m256 pull =
          _mm256_mul_ps(inverse, _mm256_fmadd_ps(_mm256_loadu_ps(&hooke_[s]), strain, damped));
      const __m256 f[] = {_mm256_mul_ps(d[0], _mm256_permute_ps(pull, 0x00)),
                          _mm256_mul_ps(d[1], _mm256_permute_ps(pull, 0x55)),
                          _mm256_mul_ps(d[2], _mm256_permute_ps(pull, 0xaa)),
                          _mm256_mul_ps(d[3], _mm256_permute_ps(pull, 0xff))};
#pragma GCC unroll 4
      for (int k = 0; k < 4; ++k) Exert(_mm256_castps256_ps128(f[k]), a[k], b[k], force);
#pragma GCC unroll 4
      for (int k = 0; k < 4; ++k) {
        Exert(_mm256_extractf128_ps(f[k], 1), a[k + 4], b[k + 4], force);
      }
    }
    for (; s < end; ++s) PullOne(force, s);
  }

  static void Exert(__m128 f, uint32_t a, uint32_t b, float* force) {
    _mm_store_ps(force + 4 * a, _mm_add_ps(_mm_load_ps(force + 4 * a), f));
    _mm_store_ps(force + 4 * b, _mm_sub_ps(_mm_load_ps(force + 4 * b), f));
  }

  void PullOne(float* force, uint64_t s) const {
    const __m128 d = _mm_sub_ps(_mm_load_ps(position_[second_[s]].value),
                                _mm_load_ps(position_[first_[s]].value));
    const __m128 u = _mm_sub_ps(_mm_load_ps(velocity_[second_[s]].value),
                                _mm_load_ps(velocity_[first_[s]].value));
    const float r = _mm_cvtss_f32(_mm_sqrt_ss(_mm_dp_ps(d, d, 0x7f)));
    const float du = _mm_cvtss_f32(_mm_dp_ps(d, u, 0x7f));
    const float pull = (hooke_[s] * (r - length_[s]) + damping_[s] * du / r) / r;
    Exert(_mm_mul_ps(d, _mm_set1_ps(pull)), first_[s], second_[s], force);
  }

  void Move(uint64_t begin, uint64_t end, float dt) {
    const __m128 zero = _mm_setzero_ps();
    for (uint64_t i = begin; i < end; ++i) {
      __m128 sum = zero;
      for (auto& force : force_) {
        sum = _mm_add_ps(sum, _mm_load_ps(force[i].value));
        _mm_store_ps(force[i].value, zero);
      }
      const __m128 v =
          _mm_fmadd_ps(sum, _mm_set1_ps(inverse_mass_[i] * dt), _mm_load_ps(velocity_[i].value));
      _mm_store_ps(velocity_[i].value, v);
      _mm_store_ps(position_[i].value,
                   _mm_fmadd_ps(v, _mm_set1_ps(dt), _mm_load_ps(position_[i].value)));
    }
  }

  int threads_;
  std::vector<Body> position_, velocity_;
  std::vector<float> inverse_mass_;
  std::vector<uint32_t> first_, second_;
  std::vector<float> length_, hooke_, damping_;
  std::vector<std::vector<Body>> force_;  // one for each thread
};

}  // namespace bench
