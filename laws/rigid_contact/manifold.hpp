// SPDX-License-Identifier: Apache-2.0
// Where two convex shapes touch, or nearly do.
#pragma once

#include <array>
#include <cstdint>

#include "shape.hpp"

namespace vesper::rigid {

/** A point where two shapes touch. */
struct ContactPoint {
  Vector at;              // in the middle between the surfaces [m]
  double separation = 0;  // along the normal [m]; negative: the shapes overlap
};

/** The points of two shapes that touch. */
struct Manifold {
  static constexpr int kMost = 4;

  Vector normal;  // from the first shape to the second, of length 1
  std::array<ContactPoint, kMost> points;
  int count = 0;

  void Add(const ContactPoint& point) { points[count++] = point; }
};

/** Returns the points at which two shapes touch or have a distance of at most `margin` [m]. Planes
 *  touch only what is in front of them. Finite for all finite shapes. */
Manifold Collide(const Shape& a, const Shape& b, double margin);

/** The closest points of two cores. */
struct ClosestPoints {
  Vector a, b;
  double distance = 0;  // 0: the cores overlap, and the points mean nothing
};

/** Returns the closest points of two cores, which are made smaller by `rounding` on all sides
 *  (Gilbert, Johnson and Keerthi 1988). */
ClosestPoints FindClosest(const Shape& a, double rounding_a, const Shape& b, double rounding_b);

}  // namespace vesper::rigid
