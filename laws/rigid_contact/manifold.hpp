// SPDX-License-Identifier: Apache-2.0
// Contact points of two convex shapes that touch, or nearly do.
#pragma once

#include <array>
#include <cstdint>

#include "shape.hpp"

namespace vesper::rigid {

/** A point where two shapes touch. */
struct ContactPoint {
  Vector at;              // in the middle between the two surfaces [m]
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

/** Returns the points at which two shapes touch or have a distance of at most `margin` [m]. A plane
 *  touches only shapes whose centre is in front of it. The result is finite for all finite shapes.
 *  */
Manifold Collide(const Shape& a, const Shape& b, double margin);

/** The closest points of two cores. */
struct ClosestPoints {
  Vector a, b;
  double distance = 0;  // 0: the cores overlap, and `points` have no meaning
};

/** Returns the closest points of two cores, each shrunk by its `rounding` on all sides (Gilbert,
 *  Johnson and Keerthi 1988). */
ClosestPoints FindClosest(const Shape& a, double rounding_a, const Shape& b, double rounding_b);

}  // namespace vesper::rigid
