// SPDX-License-Identifier: Apache-2.0
// The fastest direct summation of softened gravitation for one type of processor that the authors
// know. It uses AVX-512 with approximate reciprocal roots, and OpenMP. It is the reference for the
// law. Its bits depend on the processor and on the number of threads.
#pragma once

#include <immintrin.h>
#include <omp.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace bench {

/// Columns of positions, masses and accelerations; the number of bodies is a multiple of 64.
template <class Real>
struct Bodies {
  struct alignas(64) Line {
    Real value[64 / sizeof(Real)];
  };
  static std::vector<Line> Column(uint64_t n) { return std::vector<Line>(n * sizeof(Real) / 64); }
  explicit Bodies(uint64_t n) : count(n), columns(7, Column(n)) {}

  Real* operator[](int c) { return columns[c].data()->value; }
  uint64_t count;
  std::vector<std::vector<Line>> columns;  // x y z mass, ax ay az
};

/// Computes each pair once, in float: 4 bodies with vectors of 16 bodies. The reactions are summed
/// in a buffer for each thread.
class ThirdLawKernel {
 public:
  ThirdLawKernel(Bodies<float>& bodies, int threads) : bodies_(bodies), threads_(threads) {
    for (int i = 0; i < 3 * threads; ++i) sums_.push_back(Bodies<float>::Column(bodies.count));
  }

  void Run(float softening2) {
    const int64_t n = static_cast<int64_t>(bodies_.count);
#pragma omp parallel num_threads(threads_)
    {
      float* own[3];
      for (int c = 0; c < 3; ++c) {
        auto& column = sums_[3 * omp_get_thread_num() + c];
        std::fill(column.begin(), column.end(), Bodies<float>::Line{});
        own[c] = column.data()->value;
      }
#pragma omp for schedule(dynamic, 16)
      for (int64_t i = 0; i < n; i += 4) Rows(i, softening2, own);
#pragma omp for schedule(static)
      for (int64_t i = 0; i < n; ++i) {
        for (int c = 0; c < 3; ++c) {
          float sum = 0;
          for (int t = 0; t < threads_; ++t) sum += sums_[3 * t + c].data()->value[i];
          bodies_[4 + c][i] = sum;
        }
      }
    }
  }

 private:
  /// Returns r^-3 from the processor's 14-bit approximation with one correction.
  static __m512 InverseCube(__m512 r2) {
    const __m512 one = _mm512_set1_ps(1), guess = _mm512_rsqrt14_ps(r2);
    const __m512 square = _mm512_mul_ps(guess, guess);
    const __m512 error = _mm512_fnmadd_ps(r2, square, one);
    return _mm512_mul_ps(_mm512_mul_ps(guess, square),
                         _mm512_fmadd_ps(error, _mm512_set1_ps(1.5f), one));
  }

  /// Sums of the rows, in registers.
  struct Sums {
    __m512 x[4], y[4], z[4];
  };

  /// Adds the rows [i, i + 4) with the 16 bodies from j on; `both`: also adds the reactions.
  template <bool both>
  void Block(int64_t i, int64_t j, __m512 softening2, Sums& rows, float* const sums[3]) {
    const float *x = bodies_[0], *y = bodies_[1], *z = bodies_[2], *m = bodies_[3];
    const __m512 xj = _mm512_load_ps(x + j), yj = _mm512_load_ps(y + j), zj = _mm512_load_ps(z + j),
                 mj = _mm512_load_ps(m + j);
    __m512 bx = _mm512_load_ps(sums[0] + j), by = _mm512_load_ps(sums[1] + j),
           bz = _mm512_load_ps(sums[2] + j);
#pragma GCC unroll 4
    for (int u = 0; u < 4; ++u) {
      const __m512 dx = _mm512_sub_ps(xj, _mm512_set1_ps(x[i + u]));
      const __m512 dy = _mm512_sub_ps(yj, _mm512_set1_ps(y[i + u]));
      const __m512 dz = _mm512_sub_ps(zj, _mm512_set1_ps(z[i + u]));
      const __m512 r2 =
          _mm512_fmadd_ps(dx, dx, _mm512_fmadd_ps(dy, dy, _mm512_fmadd_ps(dz, dz, softening2)));
      const __m512 cube = InverseCube(r2), pull = _mm512_mul_ps(cube, mj);
      rows.x[u] = _mm512_fmadd_ps(pull, dx, rows.x[u]);
      rows.y[u] = _mm512_fmadd_ps(pull, dy, rows.y[u]);
      rows.z[u] = _mm512_fmadd_ps(pull, dz, rows.z[u]);
      if constexpr (both) {
        const __m512 back = _mm512_mul_ps(cube, _mm512_set1_ps(m[i + u]));
        bx = _mm512_fnmadd_ps(back, dx, bx);
        by = _mm512_fnmadd_ps(back, dy, by);
        bz = _mm512_fnmadd_ps(back, dz, bz);
      }
    }
    if constexpr (both) {
      _mm512_store_ps(sums[0] + j, bx);
      _mm512_store_ps(sums[1] + j, by);
      _mm512_store_ps(sums[2] + j, bz);
    }
  }

  void Rows(int64_t i, float softening, float* const sums[3]) {
    const __m512 softening2 = _mm512_set1_ps(softening);
    Sums rows;
    for (int u = 0; u < 4; ++u) rows.x[u] = rows.y[u] = rows.z[u] = _mm512_setzero_ps();
    const int64_t own = i / 16 * 16, n = static_cast<int64_t>(bodies_.count);
    Block<false>(i, own, softening2, rows, sums);  // this block contains each pair in both orders
    for (int64_t j = own + 16; j < n; j += 16) Block<true>(i, j, softening2, rows, sums);
    for (int u = 0; u < 4; ++u) {
      sums[0][i + u] += _mm512_reduce_add_ps(rows.x[u]);
      sums[1][i + u] += _mm512_reduce_add_ps(rows.y[u]);
      sums[2][i + u] += _mm512_reduce_add_ps(rows.z[u]);
    }
  }

  Bodies<float>& bodies_;
  int threads_;
  std::vector<std::vector<Bodies<float>::Line>> sums_;
};

/// Computes every pair in both orders, in double: 4 vectors of 8 bodies with one body.
inline void RunBothSides(Bodies<double>& bodies, double softening2, int threads) {
  const int64_t n = static_cast<int64_t>(bodies.count);
  const double *x = bodies[0], *y = bodies[1], *z = bodies[2], *m = bodies[3];
  double *ax = bodies[4], *ay = bodies[5], *az = bodies[6];
  const __m512d e = _mm512_set1_pd(softening2), one = _mm512_set1_pd(1);
#pragma omp parallel for schedule(static) num_threads(threads)
  for (int64_t i = 0; i < n; i += 32) {
    __m512d sx[4], sy[4], sz[4], xi[4], yi[4], zi[4];
    for (int u = 0; u < 4; ++u) {
      xi[u] = _mm512_load_pd(x + i + 8 * u);
      yi[u] = _mm512_load_pd(y + i + 8 * u);
      zi[u] = _mm512_load_pd(z + i + 8 * u);
      sx[u] = sy[u] = sz[u] = _mm512_setzero_pd();
    }
    for (int64_t j = 0; j < n; ++j) {
      const __m512d xj = _mm512_set1_pd(x[j]), yj = _mm512_set1_pd(y[j]), zj = _mm512_set1_pd(z[j]),
                    mj = _mm512_set1_pd(m[j]);
#pragma GCC unroll 4
      for (int u = 0; u < 4; ++u) {
        const __m512d dx = _mm512_sub_pd(xj, xi[u]), dy = _mm512_sub_pd(yj, yi[u]),
                      dz = _mm512_sub_pd(zj, zi[u]);
        const __m512d r2 =
            _mm512_fmadd_pd(dx, dx, _mm512_fmadd_pd(dy, dy, _mm512_fmadd_pd(dz, dz, e)));
        const __m512d guess = _mm512_rsqrt14_pd(r2), square = _mm512_mul_pd(guess, guess);
        const __m512d error = _mm512_fnmadd_pd(r2, square, one);
        __m512d p = _mm512_fmadd_pd(error, _mm512_set1_pd(2.1875), _mm512_set1_pd(1.875));
        p = _mm512_fmadd_pd(_mm512_fmadd_pd(p, error, _mm512_set1_pd(1.5)), error, one);
        const __m512d pull = _mm512_mul_pd(_mm512_mul_pd(_mm512_mul_pd(mj, guess), square), p);
        sx[u] = _mm512_fmadd_pd(pull, dx, sx[u]);
        sy[u] = _mm512_fmadd_pd(pull, dy, sy[u]);
        sz[u] = _mm512_fmadd_pd(pull, dz, sz[u]);
      }
    }
    for (int u = 0; u < 4; ++u) {
      _mm512_store_pd(ax + i + 8 * u, sx[u]);
      _mm512_store_pd(ay + i + 8 * u, sy[u]);
      _mm512_store_pd(az + i + 8 * u, sz[u]);
    }
  }
}

}  // namespace bench
