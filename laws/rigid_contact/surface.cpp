// SPDX-License-Identifier: Apache-2.0
// Contacts of convex shapes with surfaces of triangles.
#include <algorithm>

#include "clip.hpp"

namespace vesper::rigid {
namespace {

// Cosine of the largest angle between the normals of contacts that are merged.
constexpr double kSameDirection = 0.9995;
// Distance up to which two contact points count as one point, as a fraction of the extent of the
// shape.
constexpr double kSamePlace = 1e-4;

/** A triangle as a polyhedron with one face. */
struct Flat {
  static constexpr std::array<uint32_t, 2> kFirst = {0, 3};
  static constexpr std::array<uint32_t, 3> kAround = {0, 1, 2}, kTouching = {0, 0, 0};
  static constexpr std::array<uint32_t, 4> kBegin = {0, 1, 2, 3};

  explicit Flat(const Surface::Triangle& triangle) {
    polytope.corners = polytope.core = triangle.corners;
    polytope.normals = std::span(&triangle.normal, 1);
    polytope.first = kFirst;
    polytope.around = kAround;
    polytope.begin = kBegin;
    polytope.touching = kTouching;
    for (const Vector& corner : triangle.corners) {
      polytope.bound = std::max(polytope.bound, Length(corner));
    }
  }

  Polytope polytope;
};

}  // namespace

void SurfaceContacts::Find(const Surface& surface, const Shape& pose, const Shape& other,
                           double margin) {
  found_.clear();
  used_ = 0;
  manifolds_.clear();
  const Vector centre = pose.axes.ToOwn(other.position - pose.position);
  const Vector high{other.Reach(pose.axes.x) + margin, other.Reach(pose.axes.y) + margin,
                    other.Reach(pose.axes.z) + margin};
  const Vector low{other.Reach(-pose.axes.x) + margin, other.Reach(-pose.axes.y) + margin,
                   other.Reach(-pose.axes.z) + margin};
  surface.Find(centre - low, centre + high, found_);
  Shape triangle = pose;
  triangle.code = ShapeCode::kTriangle;
  const double same = kSamePlace * other.Bound();
  for (const uint32_t i : found_) {
    const Flat flat(surface[i]);
    triangle.hull = &flat.polytope;
    const Manifold manifold = CollideTriangle(triangle, surface[i].edges, other, margin);
    std::vector<ContactPoint>* points = manifold.count > 0 ? PointsAlong(manifold.normal) : nullptr;
    if (points == nullptr) continue;
    for (int k = 0; k < manifold.count; ++k) {
      const ContactPoint& point = manifold.points[k];
      const bool known = std::ranges::any_of(*points, [&](const ContactPoint& p) {
        const Vector way = p.at - point.at;
        return Dot(way, way) < same * same;
      });
      if (!known) points->push_back(point);
    }
  }
  for (size_t i = 0; i < used_; ++i) {
    Manifold& merged = manifolds_.emplace_back();
    merged.normal = groups_[i].normal;
    ChooseSteadily(groups_[i].points, merged.normal, merged);
  }
}

std::vector<ContactPoint>* SurfaceContacts::PointsAlong(const Vector& normal) {
  for (size_t i = 0; i < used_; ++i) {
    if (Dot(groups_[i].normal, normal) > kSameDirection) return &groups_[i].points;
  }
  if (used_ == kMostDirections) return nullptr;
  if (used_ == groups_.size()) groups_.emplace_back();
  groups_[used_].normal = normal;
  groups_[used_].points.clear();
  return &groups_[used_++].points;
}

}  // namespace vesper::rigid
