// SPDX-License-Identifier: Apache-2.0
// Convex shapes at a place in the world: their extent, inertia, and farthest points and faces in a
// direction.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "form.hpp"
#include "rigid/rotation.hpp"

namespace vesper::rigid {

/** Codes of the column `shape`, and of shapes that only contacts use. */
enum class ShapeCode : int32_t {
  kNone = 0,
  kSphere = 1,
  kBox = 2,
  kPlane = 3,
  kMesh = 4,
  kCapsule = 5,
  kCylinder = 6,
  kEllipsoid = 7,
  kTriangle = 100,  // a triangle of a surface
  kSurface = 101,   // the triangles of an immovable mesh
};

/** The axes of a body in the world: the columns of its rotation matrix. */
struct Axes {
  Vector x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  static Axes Of(const Quaternion& q) {
    return {q.Rotate({1, 0, 0}), q.Rotate({0, 1, 0}), q.Rotate({0, 0, 1})};
  }
  const Vector& operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  Vector ToWorld(const Vector& own) const { return x * own.x + y * own.y + z * own.z; }
  Vector ToOwn(const Vector& world) const { return {Dot(x, world), Dot(y, world), Dot(z, world)}; }
};

inline double Component(const Vector& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }

/** A face, an edge or a corner of a shape, given by its corners in order around it. */
struct Face {
  static constexpr int kMost = 8;
  std::array<Vector, kMost> corners;
  int count = 0;

  void Add(const Vector& corner) { corners[count++] = corner; }
};

/** A convex shape in the world. It consists of all points within the distance `radius` of its core.
 *  The core of a sphere is its centre, and the core of a capsule is its axis. Other shapes have
 *  radius 0. A mesh is replaced by its convex hull. */
struct Shape {
  // Number of corners of the polygon that replaces the cap of a cylinder in contacts.
  static constexpr int kCapCorners = 8;

  ShapeCode code = ShapeCode::kNone;
  Vector half;  // half extents of the core along its own axes; a cylinder's x and z are its radius
  double radius = 0;
  Vector position;
  Axes axes;
  const Polytope* hull = nullptr;  // hull of a mesh or triangle

  /** Returns the shape with these values of the columns; its code is kNone if it does not collide.
   *  `size` is the extent along the shape's own axes, `hull` the convex hull of a mesh. */
  static Shape Of(int32_t code, const Vector& size, const Vector& position, const Quaternion& q,
                  const Polytope* hull = nullptr) {
    Shape shape;
    shape.position = position;
    shape.code = static_cast<ShapeCode>(code);
    const Vector half = size * 0.5;
    switch (shape.code) {
      case ShapeCode::kSphere:
        shape.radius = half.x;
        break;
      case ShapeCode::kCapsule:
        shape.radius = half.x;
        shape.half = {0, std::max(0.0, half.y - half.x), 0};
        break;
      case ShapeCode::kBox:
      case ShapeCode::kCylinder:
      case ShapeCode::kEllipsoid:
        shape.half = half;
        break;
      case ShapeCode::kPlane:
        shape.half = {half.x, 0, half.z};
        break;
      case ShapeCode::kMesh:
        shape.hull = hull;
        if (hull == nullptr) shape.code = ShapeCode::kNone;
        break;
      default:
        shape.code = ShapeCode::kNone;
    }
    if (shape.code != ShapeCode::kSphere) shape.axes = Axes::Of(q);
    return shape;
  }

  /** Returns the extent from the origin along a direction in the world [m], including the radius.
   */
  double Reach(const Vector& direction) const {
    const Vector own = axes.ToOwn(direction);
    if (hull != nullptr) return Dot(Polytope::Farthest(hull->corners, own), own);
    if (code == ShapeCode::kEllipsoid) return Length(Stretched(own));
    const double along_y = std::abs(own.y) * half.y;
    if (code == ShapeCode::kCylinder) {
      return along_y + half.x * std::sqrt(own.x * own.x + own.z * own.z);
    }
    const double of_core = std::abs(own.x) * half.x + along_y + std::abs(own.z) * half.z;
    return radius > 0 ? of_core + radius * std::sqrt(Dot(own, own)) : of_core;
  }

  /** Returns the smallest extent [m], which limits the depth to which other shapes can
   *  penetrate. */
  double Thickness() const {
    switch (code) {
      case ShapeCode::kSphere:
      case ShapeCode::kCapsule:
        return 2 * radius;
      case ShapeCode::kCylinder:
        return 2 * std::min(half.x, half.y);
      case ShapeCode::kPlane:
        return 2 * std::min(half.x, half.z);
      case ShapeCode::kMesh:
        return hull->thickness;
      case ShapeCode::kTriangle:
      case ShapeCode::kSurface:
        return HUGE_VAL;
      default:
        return 2 * std::min({half.x, half.y, half.z});
    }
  }

  /** Returns the distance from the centre to the farthest point [m]. */
  double Bound() const {
    if (hull != nullptr) return hull->bound;
    if (code == ShapeCode::kEllipsoid) return std::max({half.x, half.y, half.z});
    const double square =
        code == ShapeCode::kCylinder ? half.x * half.x + half.y * half.y : Dot(half, half);
    return std::sqrt(square) + radius;
  }

  /** Returns the point of the core that is farthest in a direction. The core is first shrunk by
   *  `rounding` [m] on all sides. For a hull, `rounding` is 0 or the hull's own rounding. */
  Vector Support(const Vector& direction, double rounding = 0) const {
    if (code == ShapeCode::kSphere) return position;
    const Vector d = axes.ToOwn(direction);
    if (hull != nullptr) {
      return position +
             axes.ToWorld(Polytope::Farthest(rounding > 0 ? hull->core : hull->corners, d));
    }
    if (code == ShapeCode::kEllipsoid) return EllipsoidSupport(d, rounding);
    const auto side = [](double size, double along) { return along < 0 ? -size : size; };
    if (code == ShapeCode::kCylinder) {
      const double across = std::sqrt(d.x * d.x + d.z * d.z);
      const double scale = across > 0 ? (half.x - rounding) / across : 0;
      return position + axes.ToWorld({d.x * scale, side(half.y - rounding, d.y), d.z * scale});
    }
    if (code == ShapeCode::kCapsule) return position + axes.y * side(half.y, d.y);
    return position + axes.ToWorld({side(half.x - rounding, d.x), side(half.y - rounding, d.y),
                                    side(half.z - rounding, d.z)});
  }

  /** Returns the least radius of curvature of the surface of an ellipsoid [m]. */
  double LeastCurvature() const {
    const double least = std::min({half.x, half.y, half.z}),
                 most = std::max({half.x, half.y, half.z});
    return most > 0 ? least * least / most : 0;
  }

  /** Returns the face, edge or corner of the core that faces a direction. */
  Face SupportFace(const Vector& direction) const {
    const Vector d = axes.ToOwn(direction);
    switch (code) {
      case ShapeCode::kBox:
      case ShapeCode::kPlane:
        return BoxFace(d);
      case ShapeCode::kCylinder:
        return CylinderFace(d);
      case ShapeCode::kMesh:
      case ShapeCode::kTriangle:
        return HullFace(d);
      case ShapeCode::kEllipsoid: {
        Face corner;
        corner.Add(Support(direction));
        return corner;
      }
      case ShapeCode::kCapsule: {
        Face edge;
        edge.Add(position + axes.y * half.y);
        edge.Add(position - axes.y * half.y);
        return edge;
      }
      default: {
        Face corner;
        corner.Add(position);
        return corner;
      }
    }
  }

  /** Returns the principal moments of inertia of a homogeneous solid of this shape [kg m^2]. */
  Vector Moments(double mass) const {
    const auto square = [](double x) { return 4 * x * x; };
    switch (code) {
      case ShapeCode::kSphere: {
        const double moment = 0.4 * mass * radius * radius;
        return {moment, moment, moment};
      }
      case ShapeCode::kCapsule:
        return CapsuleMoments(mass);
      case ShapeCode::kCylinder: {
        const double across = mass * (3 * half.x * half.x + square(half.y)) / 12;
        return {across, mass * half.x * half.x / 2, across};
      }
      case ShapeCode::kBox:
      case ShapeCode::kPlane:
        return Vector{square(half.y) + square(half.z), square(half.x) + square(half.z),
                      square(half.x) + square(half.y)} *
               (mass / 12);
      case ShapeCode::kEllipsoid:
        return Vector{square(half.y) + square(half.z), square(half.x) + square(half.z),
                      square(half.x) + square(half.y)} *
               (mass / 20);
      case ShapeCode::kMesh:
        return hull->moments * mass;
      default:
        return {};
    }
  }

  /** Returns the volume [m^3]. */
  double Volume() const {
    constexpr double kPi = 3.14159265358979323846;
    switch (code) {
      case ShapeCode::kSphere:
      case ShapeCode::kCapsule:
        return kPi * radius * radius * (2 * half.y + 4 * radius / 3);
      case ShapeCode::kCylinder:
        return 2 * kPi * half.x * half.x * half.y;
      case ShapeCode::kBox:
        return 8 * half.x * half.y * half.z;
      case ShapeCode::kEllipsoid:
        return 4 * kPi / 3 * half.x * half.y * half.z;
      case ShapeCode::kMesh:
        return hull->volume;
      default:
        return 0;
    }
  }

 private:
  /** Returns a vector of the own axes, each component times the half extent. */
  Vector Stretched(const Vector& own) const {
    return {own.x * half.x, own.y * half.y, own.z * half.z};
  }

  /** Returns the farthest point of an ellipsoid in a direction of its own axes, moved inwards along
   *  the normal by `rounding`. These points are those of a convex core as long as the rounding does
   *  not exceed the least radius of curvature, and the ellipsoid consists exactly of the points
   *  within the distance `rounding` of this core. */
  Vector EllipsoidSupport(const Vector& d, double rounding) const {
    const Vector ball = Stretched(d);
    const double length = Length(ball);
    if (!(length > 0)) return position;
    Vector own = Stretched(ball) * (1 / length);
    if (rounding > 0) own = own - d * (rounding / Length(d));
    return position + axes.ToWorld(own);
  }

  Vector CapsuleMoments(double mass) const {
    const double r = radius, h = 2 * half.y;
    const double ball = 4 * r / (4 * r + 3 * h);  // fraction of the mass in the two half balls
    const double rod = 1 - ball;
    const double across =
        mass * (rod * (r * r / 4 + h * h / 12) + ball * (0.4 * r * r + h * h / 4 + 3 * h * r / 8));
    return {across, mass * r * r * (rod / 2 + ball * 0.4), across};
  }

  Face BoxFace(const Vector& d) const {
    const double ax = std::abs(d.x), ay = std::abs(d.y), az = std::abs(d.z);
    const int axis = code == ShapeCode::kPlane || (ay >= ax && ay >= az) ? 1 : ax >= az ? 0 : 2;
    const double sign = Component(d, axis) < 0 ? -1 : 1;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const Vector centre = position + axes[axis] * (sign * Component(half, axis));
    const Vector a = axes[u] * (sign * Component(half, u)), b = axes[v] * Component(half, v);
    Face face;
    face.Add(centre - a - b);
    face.Add(centre + a - b);
    face.Add(centre + a + b);
    face.Add(centre - a + b);
    return face;
  }

  /** Returns a face of a hull. If the face has more corners than a Face can contain, returns the
   *  corners that are farthest in some directions around the face. */
  Face HullFace(const Vector& d) const {
    const size_t chosen = hull->FaceTowards(d);
    const auto around =
        hull->around.subspan(hull->first[chosen], hull->first[chosen + 1] - hull->first[chosen]);
    Face face;
    if (around.size() <= Face::kMost) {
      for (const uint32_t corner : around) {
        face.Add(position + axes.ToWorld(hull->corners[corner]));
      }
      return face;
    }
    const Vector& normal = hull->normals[chosen];
    const Vector u = hull->corners[around[1]] - hull->corners[around[0]], v = Cross(normal, u);
    constexpr double kDiagonal = 0.70710678118654752;
    constexpr std::array<double, Face::kMost> kCos = {1,  kDiagonal,  0, -kDiagonal,
                                                      -1, -kDiagonal, 0, kDiagonal};
    size_t last = around.size(), first = around.size();
    for (int i = 0; i < Face::kMost; ++i) {
      const Vector way = u * kCos[i] + v * kCos[(i + 6) % Face::kMost];
      size_t found = 0;
      for (size_t k = 1; k < around.size(); ++k) {
        if (Dot(hull->corners[around[k]], way) > Dot(hull->corners[around[found]], way)) found = k;
      }
      if (found == last || found == first) continue;
      if (i == 0) first = found;
      last = found;
      face.Add(position + axes.ToWorld(hull->corners[around[found]]));
    }
    return face;
  }

  /** Returns the face of a cylinder in a direction. It is a cap, replaced by a polygon, or the line
   *  along the side. */
  Face CylinderFace(const Vector& d) const {
    const double across = std::sqrt(d.x * d.x + d.z * d.z);
    const double x = across > 1e-9 ? d.x / across : 1, z = across > 1e-9 ? d.z / across : 0;
    const Vector out = (axes.x * x + axes.z * z) * half.x;
    Face face;
    if (std::abs(d.y) * 2 < across) {
      face.Add(position + out + axes.y * half.y);
      face.Add(position + out - axes.y * half.y);
      return face;
    }
    const double sign = d.y < 0 ? -1 : 1;
    const Vector centre = position + axes.y * (sign * half.y);
    const Vector side = (axes.z * x - axes.x * z) * (-sign * half.x);
    constexpr double kDiagonal = 0.70710678118654752;
    constexpr std::array<double, kCapCorners> kCos = {1,  kDiagonal,  0, -kDiagonal,
                                                      -1, -kDiagonal, 0, kDiagonal};
    for (int i = 0; i < kCapCorners; ++i) {
      face.Add(centre + out * kCos[i] + side * kCos[(i + 6) % kCapCorners]);
    }
    return face;
  }
};

}  // namespace vesper::rigid
