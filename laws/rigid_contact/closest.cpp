// SPDX-License-Identifier: Apache-2.0
// Closest points of two convex shapes. The method is from E. G. Gilbert, D. W. Johnson, S. S.
// Keerthi, A fast procedure for computing the distance between complex objects in three-dimensional
// space, IEEE J. Robotics and Automation 4 (1988) 193.
#include <algorithm>

#include "manifold.hpp"

namespace vesper::rigid {
namespace {

constexpr int kMostIterations = 32;

/** A corner of the Minkowski difference of two shapes, and the two points whose difference it is.
 *  */
struct Corner {
  Vector w, a, b;
};

/** Up to four corners of the Minkowski difference. The weighted sum of the corners is the point of
 *  their hull that is closest to the origin.
 */
struct Simplex {
  std::array<Corner, 4> corners;
  std::array<double, 4> weights{};
  int count = 0;

  Vector Closest() const { return Mean(&Corner::w); }
  Vector Mean(Vector Corner::* point) const {
    Vector sum;
    for (int i = 0; i < count; ++i) sum += corners[i].*point * weights[i];
    return sum;
  }
  bool Contains(const Vector& w) const {
    for (int i = 0; i < count; ++i) {
      if (corners[i].w == w) return true;
    }
    return false;
  }
  void Set(std::initializer_list<Corner> chosen, std::initializer_list<double> weighted) {
    count = 0;
    const double* weight = weighted.begin();
    for (const Corner& corner : chosen) {
      corners[count] = corner;
      weights[count++] = *weight++;
    }
  }
};

void ReduceEdge(Simplex& s) {
  const Corner a = s.corners[0], b = s.corners[1];
  const Vector ab = b.w - a.w;
  const double square = Dot(ab, ab), t = -Dot(a.w, ab);
  if (!(t > 0)) return s.Set({a}, {1});
  if (t >= square) return s.Set({b}, {1});
  s.Set({a, b}, {1 - t / square, t / square});
}

// Reduces a triangle to the face, edge or corner that is closest to the origin. The method is from
// C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
void ReduceTriangle(Simplex& s) {
  const Corner a = s.corners[0], b = s.corners[1], c = s.corners[2];
  const Vector ab = b.w - a.w, ac = c.w - a.w;
  const double d1 = -Dot(ab, a.w), d2 = -Dot(ac, a.w);
  if (d1 <= 0 && d2 <= 0) return s.Set({a}, {1});
  const double d3 = -Dot(ab, b.w), d4 = -Dot(ac, b.w);
  if (d3 >= 0 && d4 <= d3) return s.Set({b}, {1});
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) {
    const double t = d1 / (d1 - d3);
    return s.Set({a, b}, {1 - t, t});
  }
  const double d5 = -Dot(ab, c.w), d6 = -Dot(ac, c.w);
  if (d6 >= 0 && d5 <= d6) return s.Set({c}, {1});
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) {
    const double t = d2 / (d2 - d6);
    return s.Set({a, c}, {1 - t, t});
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && (d4 - d3) + (d5 - d6) > 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return s.Set({b, c}, {1 - t, t});
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return s.Set({a}, {1});  // the corners lie on one line
  const double v = vb / sum, w = vc / sum;
  s.Set({a, b, c}, {1 - v - w, v, w});
}

/** Reduces a tetrahedron to the face, edge or corner that is closest to the origin. Returns false
 *  if it contains the origin. */
bool ReduceTetrahedron(Simplex& s) {
  static constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};
  const Simplex whole = s;
  double best = HUGE_VAL;
  bool outside = false;
  for (const auto& face : kFaces) {
    const Corner &a = whole.corners[face[0]], &b = whole.corners[face[1]],
                 &c = whole.corners[face[2]], &other = whole.corners[face[3]];
    const Vector normal = Cross(b.w - a.w, c.w - a.w);
    const double origin = -Dot(normal, a.w), opposite = Dot(normal, other.w - a.w);
    if (origin * opposite > 0) continue;  // the origin is on the inner side of this face
    outside = true;
    Simplex triangle;
    triangle.Set({a, b, c}, {0, 0, 0});
    ReduceTriangle(triangle);
    const Vector closest = triangle.Closest();
    const double square = Dot(closest, closest);
    if (square < best) {
      best = square;
      s = triangle;
    }
  }
  return outside;
}

bool Reduce(Simplex& s) {
  switch (s.count) {
    case 1:
      s.weights[0] = 1;
      return true;
    case 2:
      ReduceEdge(s);
      return true;
    case 3:
      ReduceTriangle(s);
      return true;
    default:
      return ReduceTetrahedron(s);
  }
}

}  // namespace

ClosestPoints FindClosest(const Shape& a, double rounding_a, const Shape& b, double rounding_b) {
  // The search approaches the closest point of a curved surface in ever smaller steps. It ends
  // before rounding errors dominate them.
  const bool curved = a.code == ShapeCode::kEllipsoid || b.code == ShapeCode::kEllipsoid;
  const double relative = curved ? 1e-9 : 1e-12;
  const double scale = a.Bound() + b.Bound();
  const double overlap = 1e-9 * scale;
  Vector v = a.position - b.position;
  if (Dot(v, v) == 0) v = {0, 1, 0};
  Simplex simplex;
  for (int i = 0; i < kMostIterations; ++i) {
    Corner corner;
    corner.a = a.Support(-v, rounding_a);
    corner.b = b.Support(v, rounding_b);
    corner.w = corner.a - corner.b;
    const double square = Dot(v, v), along = Dot(v, corner.w);
    if (simplex.count > 0) {
      if (square - along <= relative * square || simplex.Contains(corner.w)) break;
    }
    const Simplex before = curved ? simplex : Simplex{};
    simplex.corners[simplex.count++] = corner;
    if (!Reduce(simplex)) {
      if (!curved || !(along > overlap * std::sqrt(square))) return {};
      simplex = before;  // a flat tetrahedron; the plane through the new corner separates the cores
      break;
    }
    v = simplex.Closest();
    if (Dot(v, v) <= overlap * overlap) return {};
  }
  return {simplex.Mean(&Corner::a), simplex.Mean(&Corner::b), std::sqrt(Dot(v, v))};
}

}  // namespace vesper::rigid
