// SPDX-License-Identifier: Apache-2.0
// The point of a triangle closest to a given point.
#pragma once

#include <array>
#include <cstdint>

#include "vesper/law.hpp"

namespace vesper::surface_contact {

/// Part of a triangle: its interior (kFace), the edge from corner i to the next (kEdge), or corner
/// i (kCorner).
enum Feature : uint8_t { kFace, kEdge0, kEdge1, kEdge2, kCorner0, kCorner1, kCorner2 };

template <class Real>
struct Closest {
  std::array<Real, 3> weights;  // weights of the corners; not negative, their sum is 1
  Feature feature;
};

/** Returns the point of the triangle abc closest to p, by the Voronoi regions of its features
 *  (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5). The area must not be 0. */
template <class Real>
Closest<Real> ClosestOnTriangle(Vec3<Real> p, Vec3<Real> a, Vec3<Real> b, Vec3<Real> c) {
  const Vec3<Real> ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const Real d1 = Dot(ab, ap), d2 = Dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {{1, 0, 0}, kCorner0};
  const Real d3 = Dot(ab, bp), d4 = Dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {{0, 1, 0}, kCorner1};
  const Real vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const Real t = d1 / (d1 - d3);
    return {{1 - t, t, 0}, kEdge0};
  }
  const Real d5 = Dot(ab, cp), d6 = Dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {{0, 0, 1}, kCorner2};
  const Real vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const Real t = d2 / (d2 - d6);
    return {{1 - t, 0, t}, kEdge2};
  }
  const Real va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const Real t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {{0, 1 - t, t}, kEdge1};
  }
  const Real scale = 1 / (va + vb + vc);
  const Real v = vb * scale, w = vc * scale;
  return {{1 - v - w, v, w}, kFace};
}

}  // namespace vesper::surface_contact
