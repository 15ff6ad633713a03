// SPDX-License-Identifier: Apache-2.0
// Current positions of the surfaces, and tests whether a point is behind them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "closest_point.hpp"
#include "mesh_topology.hpp"
#include "vesper/law.hpp"

namespace vesper::surface_contact {

template <class Real>
Vec3<Real> Unit(Vec3<Real> v) {
  const Real length = Length(v);
  return length > 0 ? v * (1 / length) : Vec3<Real>{};
}

template <class Real>
Vec3<Real> Blend(const std::array<Real, 3>& weights, const std::array<Vec3<Real>, 3>& of) {
  return of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2];
}

/// A surface with its corners.
template <class Real>
struct Face {
  uint32_t row;
  Vec3<Real> a, b, c;
  Vec3<Real> normal;  // outwards; its length is twice the area
  Real scale;         // squared length of the normal
};

/// The closest point of a mesh that a search has found so far.
template <class Real>
struct Nearest {
  Real square;  // squared distance [m^2]; initially the square of the search radius
  uint32_t face = kNone;
  Closest<Real> at{};
  Vec3<Real> offset{};  // vector from the closest point to the given point
  Vec3<Real> normal{};  // outward normal of the face; its length is twice the area
};

/// The position of a point behind a mesh.
template <class Real>
struct Immersion {
  uint32_t face = kNone;          // row of the nearest surface; kNone: the point is not behind the
                                  // mesh
  Real depth = 0;                 // distance to the nearest point of the mesh [m], > 0
  Vec3<Real> normal{};            // unit vector from the point to the nearest point
  std::array<Real, 3> weights{};  // weights of the face's corners at the nearest point
};

/** The surfaces at their current positions. An object refers to the arguments of its constructor,
 *  which must outlive it. */
template <class Real>
class Skin {
 public:
  Skin(const MeshTopology& topology, const Vertices* vertices, const Vec3<Real>* position)
      : topology_(topology), vertices_(vertices), position_(position) {}

  Face<Real> FaceAt(uint32_t row) const {
    const auto [a, b, c] = Corners(row);
    const Vec3<Real> normal = Cross(b - a, c - a);
    return {row, a, b, c, normal, Dot(normal, normal)};
  }

  std::array<Vec3<Real>, 3> Corners(uint32_t face) const {
    const auto [a, b, c] = vertices_[face];
    return {position_[a], position_[b], position_[c]};
  }

  /** Returns true if a point is behind the mesh. `nearest` is the nearest point of the mesh, which
   *  must have been found. No point counts as behind a border. */
  bool IsBehind(const Nearest<Real>& nearest) const {
    const auto& [square, face, at, offset, normal] = nearest;
    if (at.feature == kFace) return Dot(offset, normal) < 0;
    if (at.feature < kCorner0) {
      const uint32_t neighbour = topology_.Neighbour(face, at.feature - kEdge0);
      return neighbour != kNone && Dot(offset, Unit(normal) + Unit(Normal(neighbour))) < 0;
    }
    const uint32_t corner = vertices_[face][at.feature - kCorner0];
    return !topology_.OnBorder(corner) && IsBehindCorner(offset, corner);
  }

  Immersion<Real> ImmersionAt(const Nearest<Real>& nearest) const {
    if (nearest.face == kNone) return {};
    const Real depth = std::sqrt(nearest.square);
    if (depth == 0 || !IsBehind(nearest)) return {};
    return {nearest.face, depth, Upwards(nearest, depth), nearest.at.weights};
  }

  /** Returns the unit vector from a point behind the mesh, at the depth `depth`, to the nearest
   *  point of the mesh. */
  static Vec3<Real> Upwards(const Nearest<Real>& nearest, Real depth) {
    return nearest.at.feature == kFace ? Unit(nearest.normal) : nearest.offset * (-1 / depth);
  }

 private:
  /** Returns true if the point is behind the mesh at a corner. The test uses the angle-weighted sum
   *  of the adjacent normals (J. A. Baerentzen, H. Aanaes, Signed Distance Computation Using the
   *  Angle Weighted Pseudonormal, 2005). If all faces give the same answer, the sum is not
   *  needed. */
  bool IsBehindCorner(Vec3<Real> offset, uint32_t corner) const {
    const auto around = topology_.Around(corner);
    const auto behind =
        std::ranges::count_if(around, [&](uint32_t face) { return Dot(offset, Normal(face)) < 0; });
    if (behind == 0) return false;
    if (behind == std::ssize(around)) return true;
    Vec3<Real> sum;
    for (const uint32_t face : around) sum += Unit(Normal(face)) * AngleAt(corner, face);
    return Dot(offset, sum) < 0;
  }

  Vec3<Real> Normal(uint32_t face) const {
    const auto [a, b, c] = Corners(face);
    return Cross(b - a, c - a);
  }

  /** Returns the angle at a face's corner [rad]. */
  Real AngleAt(uint32_t body, uint32_t face) const {
    auto [a, b, c] = vertices_[face];
    while (a != body) {
      const uint32_t first = a;
      a = b, b = c, c = first;
    }
    const Vec3<Real> u = position_[b] - position_[a], v = position_[c] - position_[a];
    return std::atan2(Length(Cross(u, v)), Dot(u, v));
  }

  const MeshTopology& topology_;
  const Vertices* vertices_;
  const Vec3<Real>* position_;
};

/** Stores the face in `nearest` if it is nearer to p than the stored face. A face without area has
 *  no front, so it is skipped. */
template <class Real>
void Approach(Vec3<Real> p, const Face<Real>& face, Nearest<Real>& nearest) {
  const Real height = Dot(face.normal, p - face.a);
  if (!(height * height < nearest.square * face.scale)) return;
  const Closest<Real> at = ClosestOnTriangle(p, face.a, face.b, face.c);
  const Vec3<Real> offset = p - Blend(at.weights, {face.a, face.b, face.c});
  const Real square = at.feature == kFace ? height * height / face.scale : Dot(offset, offset);
  if (square < nearest.square) nearest = {square, face.row, at, offset, face.normal};
}

}  // namespace vesper::surface_contact
