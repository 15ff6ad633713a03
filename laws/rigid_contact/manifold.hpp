// SPDX-License-Identifier: Apache-2.0
// Contact points of two convex shapes that touch, or nearly do.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shape.hpp"

namespace vesper::rigid {

/** A point where two shapes touch. */
struct ContactPoint {
  Vector at;              // place in the middle between the two surfaces [m]
  double separation = 0;  // along the normal [m]; negative: the shapes overlap
};

/** The points of two shapes that touch. */
struct Manifold {
  static constexpr int kMost = 4;

  Vector normal;  // unit vector from the first shape to the second
  std::array<ContactPoint, kMost> points;
  int count = 0;

  void Add(const ContactPoint& point) { points[count++] = point; }
};

/** Returns the points at which two shapes touch or have a distance of at most `margin` [m]. A plane
 *  touches only shapes whose centre is in front of it. The result is finite for all finite shapes.
 *  */
Manifold Collide(const Shape& a, const Shape& b, double margin);

/** Returns the points at which a triangle of a surface touches a convex shape whose centre is in
 *  front of the triangle. The normal points to the shape. Omits a contact at an edge whose bit in
 *  `edges` is 0, because the triangle at the other side of this edge has this contact. */
Manifold CollideTriangle(const Shape& triangle, uint32_t edges, const Shape& other, double margin);

/** The contacts of a convex shape with a surface of triangles, one contact for each direction of
 *  the normal. An object keeps its memory for the next search. */
class SurfaceContacts {
 public:
  // Maximum number of directions. Contacts with further directions are dropped.
  static constexpr size_t kMostDirections = 16;

  /** Finds the contacts. `pose` has the position and axes of the surface. */
  void Find(const Surface& surface, const Shape& pose, const Shape& other, double margin);
  /** Returns the contacts; the normals point from the surface to the shape. */
  const std::vector<Manifold>& manifolds() const { return manifolds_; }

 private:
  struct Group {
    Vector normal;
    std::vector<ContactPoint> points;
  };
  /** Returns the points of the group with about this normal. Adds a group if there is none; returns
   *  null if there are already kMostDirections groups. */
  std::vector<ContactPoint>* PointsAlong(const Vector& normal);

  std::vector<uint32_t> found_;
  std::vector<Group> groups_;
  size_t used_ = 0;
  std::vector<Manifold> manifolds_;
};

/** The closest points of two cores. */
struct ClosestPoints {
  Vector a, b;
  double distance = 0;  // 0: the cores overlap, and `points` have no meaning
};

/** Returns the closest points of two cores, each shrunk by its `rounding` on all sides (Gilbert,
 *  Johnson and Keerthi 1988). */
ClosestPoints FindClosest(const Shape& a, double rounding_a, const Shape& b, double rounding_b);

}  // namespace vesper::rigid
