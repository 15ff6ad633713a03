// SPDX-License-Identifier: Apache-2.0
// The device programs, in OpenCL C.
#pragma once

namespace vesper::opencl {

/** Gravitation and motion of point masses. Columns have the layout of the host: (rows x 3),
 *  tightly packed. Compiled with -DREAL=float or double, -DWIDTH= bodies per work item (1, 4, 8
 *  or 16), and -DFAST to use the device's reciprocal square root instead of a correctly rounded
 *  one. */
inline constexpr const char* kSource = R"(
#ifdef DOUBLES
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif
#pragma OPENCL FP_CONTRACT OFF

#define JOIN_TOKENS(a, b) a##b
#define JOIN(a, b) JOIN_TOKENS(a, b)
#if WIDTH == 1
typedef REAL reals;
#else
typedef JOIN(REAL, WIDTH) reals;
#endif

// Sources whose pulls are summed before they are added to the total: short sums round less.
#define BLOCK 256

reals gather(__global const REAL* rows, uint first, uint last, uint component) {
#if WIDTH == 1
  return rows[3 * first + component];
#else
  REAL lanes[WIDTH];
  for (uint lane = 0; lane < WIDTH; ++lane)
    lanes[lane] = rows[3 * min(first + lane, last) + component];
  return JOIN(vload, WIDTH)(0, lanes);
#endif
}

void scatter(reals values, uint first, uint count, uint component, __global REAL* rows) {
#if WIDTH == 1
  rows[3 * first + component] = values;
#else
  REAL lanes[WIDTH];
  JOIN(vstore, WIDTH)(values, 0, lanes);
  for (uint lane = 0; lane < WIDTH && first + lane < count; ++lane)
    rows[3 * (first + lane) + component] = lanes[lane];
#endif
}

reals inverse_cube(reals squared) {
#ifdef FAST
  const reals inverse = rsqrt(squared);
  return inverse * inverse * inverse;
#else
  return (REAL)1 / (squared * sqrt(squared));
#endif
}

// force[i] = G m[i] sum over j of m[j] (x[j] - x[i]) / (|x[j] - x[i]|^2 + softening^2)^(3/2)
__kernel void gravitation(__global const REAL* position, __global const REAL* mass,
                          __global REAL* force, uint count, REAL constant_g, REAL softening) {
  const uint first = get_global_id(0) * WIDTH;
  if (first >= count) return;
  const reals x = gather(position, first, count - 1, 0);
  const reals y = gather(position, first, count - 1, 1);
  const reals z = gather(position, first, count - 1, 2);
  const REAL softened = softening * softening;
  reals fx = 0, fy = 0, fz = 0;
  for (uint begin = 0; begin < count; begin += BLOCK) {
    const uint end = min(begin + BLOCK, count);
    reals bx = 0, by = 0, bz = 0;
    for (uint j = begin; j < end; ++j) {
      const reals dx = position[3 * j] - x;
      const reals dy = position[3 * j + 1] - y;
      const reals dz = position[3 * j + 2] - z;
      const reals squared = fma(dx, dx, fma(dy, dy, fma(dz, dz, (reals)softened)));
      // A body does not pull itself, nor one in the same place, where the pull has no direction.
      const reals pull = squared == 0 ? (reals)0 : mass[j] * inverse_cube(squared);
      bx = fma(pull, dx, bx);
      by = fma(pull, dy, by);
      bz = fma(pull, dz, bz);
    }
    fx += bx;
    fy += by;
    fz += bz;
  }
  REAL own[WIDTH];
  for (uint lane = 0; lane < WIDTH; ++lane)
    own[lane] = constant_g * mass[min(first + lane, count - 1)];
#if WIDTH == 1
  const reals weight = own[0];
#else
  const reals weight = JOIN(vload, WIDTH)(0, own);
#endif
  scatter(weight * fx, first, count, 0, force);
  scatter(weight * fy, first, count, 1, force);
  scatter(weight * fz, first, count, 2, force);
}

// energy[i] = -G m[i] / 2 sum over j != i of m[j] / sqrt(|x[j] - x[i]|^2 + softening^2)
__kernel void potential(__global const REAL* position, __global const REAL* mass,
                        __global REAL* energy, uint count, REAL constant_g, REAL softening) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  REAL sum = 0;
  for (uint j = 0; j < count; ++j) {
    const REAL dx = position[3 * j] - position[3 * i];
    const REAL dy = position[3 * j + 1] - position[3 * i + 1];
    const REAL dz = position[3 * j + 2] - position[3 * i + 2];
    const REAL squared = fma(dx, dx, fma(dy, dy, fma(dz, dz, softening * softening)));
    if (j != i && squared != 0) sum += mass[j] / sqrt(squared);
  }
  energy[i] = (REAL)-0.5 * constant_g * mass[i] * sum;
}

// Semi-implicit Euler: the velocity first, then the position with the new velocity.
__kernel void motion(__global const REAL* mass, __global const REAL* force,
                     __global REAL* velocity, __global REAL* position, uint count, REAL dt) {
  const uint i = get_global_id(0);
  if (i >= count || mass[i] == 0) return;
  const REAL impulse = dt / mass[i];
  for (uint c = 3 * i; c < 3 * i + 3; ++c) {
    velocity[c] += force[c] * impulse;
    position[c] += velocity[c] * dt;
  }
}
)";

}  // namespace vesper::opencl
