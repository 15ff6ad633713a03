// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "clip.hpp"

namespace vesper::rigid {
namespace {

using Code = ShapeCode;

// Fraction of the thickness by which corners and edges are rounded while the direction of a contact
// is sought. Therefore the direction is well defined for shapes that overlap by less than the
// rounding.
constexpr double kRounding = 0.05;

/** Returns the separation of two shapes along a direction [m]. */
double SeparationAlong(const Shape& a, const Shape& b, const Vector& direction) {
  const double way = Dot(b.position - a.position, direction);
  // Only hulls are not symmetric about their centres.
  return way - a.Reach(direction) - b.Reach(b.hull != nullptr ? -direction : direction);
}

void AddPoint(const Meeting& m, const Vector& on_a, double separation, Manifold& manifold) {
  if (separation > m.margin) return;
  manifold.Add({on_a + m.normal * (separation / 2), separation});
}

Manifold CollideBalls(const Shape& a, const Shape& b, double margin) {
  const Vector way = b.position - a.position;
  const double distance = Length(way);
  Manifold manifold;
  manifold.normal = distance > 0 ? way * (1 / distance) : Vector{0, 1, 0};
  AddPoint({a, b, manifold.normal, margin}, a.position + manifold.normal * a.radius,
           distance - a.radius - b.radius, manifold);
  return manifold;
}

/** Returns the contact points of a box and a ball. */
Manifold CollideBoxBall(const Shape& box, const Shape& ball, double margin) {
  const Vector own = box.axes.ToOwn(ball.position - box.position);
  const Vector inside{std::clamp(own.x, -box.half.x, box.half.x),
                      std::clamp(own.y, -box.half.y, box.half.y),
                      std::clamp(own.z, -box.half.z, box.half.z)};
  Manifold manifold;
  const Vector way = own - inside;
  const double distance = Length(way);
  if (distance > 0) {
    manifold.normal = box.axes.ToWorld(way * (1 / distance));
    AddPoint({box, ball, manifold.normal, margin}, box.position + box.axes.ToWorld(inside),
             distance - ball.radius, manifold);
    return manifold;
  }
  int axis = 0;
  double depth = HUGE_VAL;  // depth of the ball's centre below the nearest side
  for (int i = 0; i < 3; ++i) {
    const double below = Component(box.half, i) - std::abs(Component(own, i));
    if (below < depth) {
      depth = below;
      axis = i;
    }
  }
  manifold.normal = box.axes[axis] * (Component(own, axis) < 0 ? -1.0 : 1.0);
  AddPoint({box, ball, manifold.normal, margin}, ball.position + manifold.normal * depth,
           -depth - ball.radius, manifold);
  return manifold;
}

/** Returns the contact points of an immovable plane and a shape in front of it. */
Manifold CollidePlane(const Shape& plane, const Shape& other, double margin) {
  Manifold manifold;
  manifold.normal = plane.axes.y;
  if (Dot(other.position - plane.position, manifold.normal) < 0) return manifold;
  const Face reference = plane.SupportFace(manifold.normal);
  const Face incident = other.SupportFace(-manifold.normal);
  AddClipped({reference, manifold.normal, incident, other.radius, 0, margin, other.hull != nullptr},
             manifold);
  return manifold;
}

/** The direction of least overlap among the axes of two boxes and the cross products of these axes.
 *  */
struct BestAxis {
  Vector normal;
  double separation = -HUGE_VAL;
  int edge_a = -1, edge_b = -1;  // axes of the touching edges; -1 if a face touches
};

/** The axes of two boxes: `cosines[i][j]` is the scalar product of axis i of the first box and axis
 *  j of the second box, and `along[i]` the part of the way between the centres along axis i of the
 *  first box [m]. */
struct BoxAxes {
  std::array<std::array<double, 3>, 3> cosines;
  std::array<double, 3> along;

  BoxAxes(const Shape& a, const Shape& b, const Vector& way) {
    for (int i = 0; i < 3; ++i) {
      const Vector own = b.axes.ToOwn(a.axes[i]);
      cosines[i] = {own.x, own.y, own.z};
      along[i] = Dot(way, a.axes[i]);
    }
  }

  /** Returns whether the cross product of axis i of the first box and axis j of the second box
   *  separates the boxes by less than `bound` [m] or nearly so, or is so short that it is no
   *  direction. The errors of this estimate are far below `tolerance` [m]. */
  bool IsUseless(const Shape& a, const Shape& b, int i, int j, double bound,
                 double tolerance) const {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const double u = cosines[i1][j], v = cosines[i2][j], square = u * u + v * v;
    if (square < 0.999 * kShortest) return true;
    const double reach = Component(a.half, i1) * std::abs(v) + Component(a.half, i2) * std::abs(u) +
                         Component(b.half, j1) * std::abs(cosines[i][j2]) +
                         Component(b.half, j2) * std::abs(cosines[i][j1]);
    const double separation = std::abs(u * along[i2] - v * along[i1]) - reach;
    // Compares separation / sqrt(square) with the least bound, without a root.
    const double least = bound - tolerance;
    const double difference = separation * separation - least * least * square;
    return least < 0 ? separation < 0 && difference > 0 : separation <= 0 || difference < 0;
  }

  // Square of the length below which a cross product of two axes is no direction.
  static constexpr double kShortest = 1e-6;
};

/** Returns the axis of least overlap of two boxes. Stops early if an axis separates the boxes by
 *  more than the margin. */
BestAxis SeparateBoxes(const Shape& a, const Shape& b, double margin) {
  const Vector way = b.position - a.position;
  BestAxis best{{}, -HUGE_VAL, -1, -1};
  const double slack = 0.02 * std::min(a.Thickness(), b.Thickness()), preference = 1e-3 * slack;
  const BoxAxes axes(a, b, way);
  // Returns whether the search must stop. `cosine(k)` is the scalar product of the axis and axis k
  // of the other box.
  const auto separates = [&](const Vector& axis, double along, double half, const Shape& other,
                             auto&& cosine) {
    const double reach = std::abs(cosine(0)) * other.half.x + std::abs(cosine(1)) * other.half.y +
                         std::abs(cosine(2)) * other.half.z;
    const double separation = std::abs(along) - half - reach;
    // A small preference for the first face prevents that the result alternates between two
    // parallel faces.
    if (separation > best.separation + preference) {
      best = {along < 0 ? -axis : axis, separation, -1, -1};
    }
    return separation > margin;
  };
  for (int i = 0; i < 3; ++i) {
    if (separates(a.axes[i], axes.along[i], Component(a.half, i), b,
                  [&](int k) { return axes.cosines[i][k]; })) {
      break;
    }
  }
  if (best.separation > margin) return best;
  for (int j = 0; j < 3; ++j) {
    if (separates(b.axes[j], Dot(way, b.axes[j]), Component(b.half, j), a,
                  [&](int k) { return axes.cosines[k][j]; })) {
      break;
    }
  }
  if (best.separation > margin) return best;
  // A direction of two edges must be clearly better than that of a face, because a face gives more
  // contact points.
  double least = best.separation < 0 ? best.separation * 0.95 + slack : best.separation + slack;
  const double tolerance = 1e-9 * (a.half.x + a.half.y + a.half.z + b.half.x + b.half.y + b.half.z +
                                   std::abs(way.x) + std::abs(way.y) + std::abs(way.z));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (axes.IsUseless(a, b, i, j, std::min(least, margin), tolerance)) continue;
      const Vector axis = Cross(a.axes[i], b.axes[j]);
      const double square = Dot(axis, axis);
      if (square < BoxAxes::kShortest) continue;
      const double along = Dot(way, axis);
      const Vector normal = axis * ((along < 0 ? -1 : 1) / std::sqrt(square));
      const double separation = SeparationAlong(a, b, normal);
      if (separation > least) {
        least = separation;
        best = {normal, separation, i, j};
      }
      if (separation > margin) return best;
    }
  }
  return best;
}

/** Adds the contact point at which an edge of one box crosses an edge of the other. */
void AddCrossing(const Meeting& m, const BestAxis& axis, Manifold& manifold) {
  const auto edge = [](const Shape& box, const Vector& towards, int along) {
    const Vector corner = box.Support(towards);
    return corner - box.axes[along] * Dot(corner - box.position, box.axes[along]);
  };
  const Vector p = edge(m.a, m.normal, axis.edge_a), q = edge(m.b, -m.normal, axis.edge_b);
  const Vector &u = m.a.axes[axis.edge_a], &v = m.b.axes[axis.edge_b];
  const double cosine = Dot(u, v), sine_square = 1 - cosine * cosine;
  const double on_u = Dot(q - p, u), on_v = Dot(q - p, v);
  const double s = (on_u - cosine * on_v) / sine_square;
  AddPoint(m, p + u * s, axis.separation, manifold);
}

Manifold CollideBoxes(const Shape& a, const Shape& b, double margin) {
  Manifold manifold;
  const BestAxis axis = SeparateBoxes(a, b, margin);
  if (axis.separation > margin) return manifold;
  manifold.normal = axis.normal;
  const Meeting meeting{a, b, axis.normal, margin};
  if (axis.edge_a >= 0) {
    AddCrossing(meeting, axis, manifold);
  } else {
    ClipFaces(meeting, manifold);
  }
  return manifold;
}

/** Returns the direction of least overlap of two shapes whose cores overlap. The tested directions
 *  are the axes of the shapes, the cross products of the axes, the line between the centres, and
 *  the normals of hulls. */
Vector LeastOverlap(const Shape& a, const Shape& b) {
  Vector best{0, 1, 0};
  double most = -HUGE_VAL;
  const auto consider = [&](const Vector& axis) {
    const double square = Dot(axis, axis);
    if (!(square > 1e-6)) return;
    const double sign = Dot(b.position - a.position, axis) < 0 ? -1 : 1;
    const Vector normal = axis * (sign / std::sqrt(square));
    const double separation = SeparationAlong(a, b, normal);
    if (separation > most) {
      most = separation;
      best = normal;
    }
  };
  for (int i = 0; i < 3; ++i) {
    consider(a.axes[i]);
    consider(b.axes[i]);
    for (int j = 0; j < 3; ++j) consider(Cross(a.axes[i], b.axes[j]));
  }
  const auto consider_faces = [&](const Shape& shape, double sign) {
    if (shape.hull == nullptr) return;
    for (const Vector& own : shape.hull->normals) {
      const Vector normal = shape.axes.ToWorld(own) * sign;
      const double separation = SeparationAlong(a, b, normal);
      if (separation > most) {
        most = separation;
        best = normal;
      }
    }
  };
  consider_faces(a, 1);
  consider_faces(b, -1);
  const Vector way = b.position - a.position;
  const double distance = Length(way);
  if (distance > 0) {
    const Vector line = way * (1 / distance);
    consider(line);
    for (const Shape* shape : {&a, &b}) {
      if (shape->code == Code::kCylinder || shape->code == Code::kCapsule) {
        consider(line - shape->axes.y * Dot(line, shape->axes.y));
      }
    }
  }
  return best;
}

/** Adds the point in the middle of two shapes that overlap. */
void AddDeepest(const Meeting& m, Manifold& manifold) {
  const Vector on_a = m.a.Support(m.normal) + m.normal * m.a.radius;
  const Vector on_b = m.b.Support(-m.normal) - m.normal * m.b.radius;
  const double separation = SeparationAlong(m.a, m.b, m.normal);
  AddPoint(m, (on_a + on_b) * 0.5 - m.normal * (separation / 2), separation, manifold);
}

/** Adds the contact points of two shapes of which at least one is a hull or a triangle. The
 *  distance of a hull's core from the hull's surface is larger than the rounding at a sharp
 *  edge. Therefore the separation is computed from the whole shapes, and not from the cores. */
void AddHullPoints(const Meeting& m, const ClosestPoints& closest, Manifold& manifold) {
  const double separation = SeparationAlong(m.a, m.b, m.normal);
  if (separation > m.margin) return;
  ClipFaces(m, manifold);
  // The slack is necessary because the deepest point of two edges that cross near a face may not be
  // above the face.
  const double slack = 0.01 * std::min(m.a.Thickness(), m.b.Thickness());
  for (int i = 0; i < manifold.count; ++i) {
    if (manifold.points[i].separation <= separation + slack) return;
  }
  manifold.count = 0;
  if (!(closest.distance > 0)) return AddDeepest(m, manifold);
  const double radii = m.a.radius - m.b.radius;
  manifold.Add({(closest.a + closest.b + m.normal * radii) * 0.5, separation});
}

/** Returns the distance by which a shape is shrunk while its contact with another shape is sought.
 */
double RoundingFor(const Shape& shape, const Shape& other) {
  if (shape.radius > 0 || other.radius > 0 || shape.code == Code::kTriangle) return 0;
  if (shape.code == Code::kEllipsoid) {
    return std::min(kRounding * shape.Thickness(), 0.5 * shape.LeastCurvature());
  }
  return shape.hull != nullptr ? shape.hull->rounding : kRounding * shape.Thickness();
}

/** Returns the normal of the face that is almost perpendicular to `direction`, if the shapes
 *  overlap less along this normal. Otherwise returns `direction`. */
Vector SnapToFaces(const Shape& a, const Shape& b, const Vector& direction) {
  const double slack = 1e-3 * std::min(a.Thickness(), b.Thickness());
  Vector best = direction;
  double most = SeparationAlong(a, b, direction) - slack;
  const auto consider = [&](const Vector& normal) {
    if (Dot(normal, direction) < kFlat) return;
    const double separation = SeparationAlong(a, b, normal);
    if (separation <= most) return;
    most = separation + slack;  // keeps the first of two parallel faces
    best = normal;
  };
  consider(NormalOf(a.SupportFace(direction)));
  consider(-NormalOf(b.SupportFace(-direction)));
  return best;
}

/** Adds the only contact point of two shapes of which at least one is an ellipsoid. Because an
 *  ellipsoid has no flat parts, its farthest point in a direction is the point that touches. */
void AddEllipsoidPoint(const Meeting& m, Manifold& manifold) {
  const double separation = SeparationAlong(m.a, m.b, m.normal);
  const Vector on_a = m.b.code == Code::kEllipsoid ? m.b.Support(-m.normal) - m.normal * separation
                                                   : m.a.Support(m.normal);
  AddPoint(m, on_a, separation, manifold);
}

/** Returns the contact point of two shapes of which at least one is an ellipsoid, and none is a
 *  plane. */
Manifold CollideEllipsoid(const Shape& a, const Shape& b, double margin) {
  const ClosestPoints closest = FindClosest(a, RoundingFor(a, b), b, RoundingFor(b, a));
  Manifold manifold;
  manifold.normal =
      closest.distance > 0 ? (closest.b - closest.a) * (1 / closest.distance) : LeastOverlap(a, b);
  if (a.hull != nullptr || b.hull != nullptr) {
    manifold.normal = SnapToFaces(a, b, manifold.normal);
  }
  AddEllipsoidPoint({a, b, manifold.normal, margin}, manifold);
  return manifold;
}

/** Returns the contact points of any two convex shapes. */
Manifold CollideConvex(const Shape& a, const Shape& b, double margin) {
  const double of_a = RoundingFor(a, b), of_b = RoundingFor(b, a);
  const double radii = a.radius + of_a + b.radius + of_b;
  const ClosestPoints closest = FindClosest(a, of_a, b, of_b);
  Manifold manifold;
  const bool hulls = a.hull != nullptr || b.hull != nullptr;
  if (!hulls && closest.distance > radii + margin) return manifold;
  const bool apart = closest.distance > 0;
  manifold.normal = apart ? (closest.b - closest.a) * (1 / closest.distance) : LeastOverlap(a, b);
  if (hulls) {
    manifold.normal = SnapToFaces(a, b, manifold.normal);
    AddHullPoints({a, b, manifold.normal, margin}, closest, manifold);
    return manifold;
  }
  const Meeting meeting{a, b, manifold.normal, margin};
  ClipFaces(meeting, manifold);
  if (manifold.count > 0) return manifold;
  if (apart) {
    AddPoint(meeting, closest.a + manifold.normal * (a.radius + of_a), closest.distance - radii,
             manifold);
  } else {
    AddDeepest(meeting, manifold);
  }
  return manifold;
}

Manifold CollideInOrder(const Shape& a, const Shape& b, double margin) {
  if (a.code == Code::kPlane) {
    return b.code == Code::kPlane ? Manifold{} : CollidePlane(a, b, margin);
  }
  if (a.code == Code::kEllipsoid || b.code == Code::kEllipsoid) {
    return CollideEllipsoid(a, b, margin);
  }
  if (b.code == Code::kSphere) {
    if (a.code == Code::kSphere) return CollideBalls(a, b, margin);
    if (a.code == Code::kBox) return CollideBoxBall(a, b, margin);
  }
  if (a.code == Code::kBox && b.code == Code::kBox) return CollideBoxes(a, b, margin);
  return CollideConvex(a, b, margin);
}

/** Returns the rank by which the two shapes of a pair are ordered: planes, boxes, other shapes,
 *  balls and ellipsoids. */
int Rank(const Shape& shape) {
  switch (shape.code) {
    case Code::kPlane:
      return 0;
    case Code::kBox:
      return 1;
    case Code::kCylinder:
    case Code::kMesh:
      return 2;
    case Code::kCapsule:
      return 3;
    default:
      return 4;
  }
}

/** Returns whether a point on a triangle is on one of these edges, given as bits. */
bool TouchesEdge(const Shape& triangle, uint32_t edges, const Vector& at) {
  constexpr double kNear = 1e-3;  // fraction of the triangle's height
  const auto corners = triangle.hull->corners;
  const Vector own = triangle.axes.ToOwn(at - triangle.position);
  const Vector& normal = triangle.hull->normals[0];
  for (uint32_t side = 0; side < 3; ++side) {
    const Vector &p = corners[side], &q = corners[(side + 1) % 3], &r = corners[(side + 2) % 3];
    const Vector inwards = Cross(normal, q - p);
    if ((edges & (1u << side)) != 0 && Dot(own - p, inwards) <= kNear * Dot(r - p, inwards)) {
      return true;
    }
  }
  return false;
}

}  // namespace

Manifold Collide(const Shape& a, const Shape& b, double margin) {
  if (Rank(a) <= Rank(b)) return CollideInOrder(a, b, margin);
  Manifold manifold = CollideInOrder(b, a, margin);
  manifold.normal = -manifold.normal;
  return manifold;
}

Manifold CollideTriangle(const Shape& triangle, uint32_t edges, const Shape& other, double margin) {
  const Polytope& flat = *triangle.hull;
  const Vector face = triangle.axes.ToWorld(flat.normals[0]);
  const Vector corner = triangle.position + triangle.axes.ToWorld(flat.corners[0]);
  Manifold manifold;
  if (Dot(other.position - corner, face) < 0) return manifold;
  const ClosestPoints closest = FindClosest(triangle, 0, other, RoundingFor(other, triangle));
  manifold.normal = face;
  if (closest.distance > 0) {
    // Cosine of the largest angle between the normal of the triangle and the normal of a contact
    // with its face. A ball beside the triangle must not touch the edge of the triangle as a face.
    // A box that rests across the edge may be tilted a little.
    const double like_face = other.radius > 0 ? 1 - 1e-9 : 0.9998;
    const Vector normal = (closest.b - closest.a) * (1 / closest.distance);
    const double cosine = Dot(normal, face);
    if (cosine < like_face) {
      if (cosine < 0 || !TouchesEdge(triangle, edges, closest.a)) return manifold;
      manifold.normal = normal;
    }
  }
  const Meeting meeting{triangle, other, manifold.normal, margin};
  if (other.code == Code::kEllipsoid) {
    AddEllipsoidPoint(meeting, manifold);
  } else {
    AddHullPoints(meeting, closest, manifold);
  }
  return manifold;
}

}  // namespace vesper::rigid
