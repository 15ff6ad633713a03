// SPDX-License-Identifier: Apache-2.0
// The deepest point of an edge behind another mesh.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "skin.hpp"

namespace vesper::surface_contact {

/// Two faces with a common convex edge. If an edge of another mesh passes behind the common edge,
/// its deepest point may be between its own ends.
template <class Real>
struct Ridge {
  Vec3<Real> start;
  Vec3<Real> along;                   // the edge divided by the square of its length [1/m]
  std::array<Vec3<Real>, 2> normals;  // outward unit normals of the faces
};

/// The point of an edge that is deepest behind a mesh. This point is equally deep below two faces,
/// one in each direction along the edge.
template <class Real>
struct DeepestPoint {
  Real depth = 0;                          // [m]; 0: no point of the edge is deep enough
  Real place = 0;                          // position along the edge, from 0 to 1
  std::array<Immersion<Real>, 2> faces{};  // the two faces at this point
  std::array<Real, 2> shares{};  // weights of the two faces in `depth`; the weighted sum of their
                                 // normals is perpendicular to the edge
};

/** Search for the deepest point of an edge behind a mesh with the given ridges and faces. Behind a
 *  convex part of a mesh, the depth of a point is the minimum of its depths below the planes of the
 *  faces. The search is the cutting-plane method (J. E. Kelley, The Cutting-Plane Method for
 *  Solving Convex Programs, 1960). It starts at the intersections of the planes of each ridge. */
template <class Real>
class DeepestPointSearch {
 public:
  DeepestPointSearch(const Skin<Real>& skin, std::span<const Ridge<Real>> ridges,
                     std::span<const Face<Real>> faces)
      : skin_(skin), ridges_(ridges), faces_(faces) {}

  /** Returns the deepest point of the edge from `start` to `end`, if its depth is above `least`
   *  and below `most` [m]. */
  DeepestPoint<Real> Find(Vec3<Real> start, Vec3<Real> end, Real least, Real most) const {
    DeepestPoint<Real> deepest;
    Real bar = least;
    for (const Ridge<Real>& ridge : ridges_) {
      Slopes slopes;
      if (!Crosses(ridge, start, end, bar, most, slopes)) continue;
      const DeepestPoint<Real> found = Descend(start, end - start, slopes, bar, most);
      if (found.depth > bar) {
        deepest = found;
        bar = found.depth;
      }
    }
    return deepest;
  }

 private:
  static constexpr int kRounds = 12;
  /// Relative tolerance of the depth: the search stops when a new plane reduces the depth by less.
  static constexpr Real kTolerance = Real(1e-4);

  /// Depth below a plane along an edge [m]: the depth at the edge's start, and the change of the
  /// depth up to the edge's end.
  struct Slope {
    Real at_start, growth;
    Real At(Real place) const { return at_start + place * growth; }
  };
  /// The planes that limit the depth on each side of a point. Along the edge, the depth below the
  /// plane `down` grows, and the depth below the plane `up` decreases.
  struct Slopes {
    Slope down, up;
    Real Meeting() const { return (up.at_start - down.at_start) / (down.growth - up.growth); }
  };

  static bool Crosses(const Ridge<Real>& ridge, Vec3<Real> start, Vec3<Real> end, Real bar,
                      Real most, Slopes& slopes) {
    const auto slope = [&](Vec3<Real> normal) {
      const Real at_start = Dot(normal, ridge.start - start);
      return Slope{at_start, Dot(normal, start - end)};
    };
    const Slope first = slope(ridge.normals[0]), second = slope(ridge.normals[1]);
    if (!(first.growth * second.growth <= 0) || first.growth == second.growth) return false;
    slopes = first.growth > 0 ? Slopes{first, second} : Slopes{second, first};
    const Real place = slopes.Meeting();
    if (!(place > 0 && place < 1)) return false;
    const Real depth = slopes.down.At(place);
    if (!(depth > bar && depth < most)) return false;
    const Real along = Dot(ridge.along, start + (end - start) * place - ridge.start);
    return along > 0 && along < 1;
  }

  DeepestPoint<Real> Descend(Vec3<Real> start, Vec3<Real> edge, Slopes slopes, Real bar,
                             Real most) const {
    for (int round = 1;; ++round) {
      const Real place = slopes.Meeting(), bound = slopes.down.At(place);
      if (!(place > 0 && place < 1 && bound > bar)) return {};
      const Vec3<Real> point = start + edge * place;
      const Real reach = std::min(bound * Real(1.25), most);
      Nearest<Real> down{reach * reach}, up{reach * reach};
      FindNearest(point, edge, down, up);
      const Immersion<Real> ahead = skin_.ImmersionAt(down), back = skin_.ImmersionAt(up);
      const bool both = ahead.face != kNone && back.face != kNone;
      const auto slope = [&](const Immersion<Real>& face) {
        const Real growth = -Dot(face.normal, edge);
        return Slope{face.depth - place * growth, growth};
      };
      if (ahead.face != kNone) slopes.down = slope(ahead);
      if (back.face != kNone) slopes.up = slope(back);
      const Real cut = bound - slopes.down.At(slopes.Meeting());
      if (both && (std::abs(cut) <= kTolerance * bound || round == kRounds)) {
        const Real share = slopes.up.growth / (slopes.up.growth - slopes.down.growth);
        const Real depth = share * ahead.depth + (1 - share) * back.depth;
        return {depth, place, {ahead, back}, {share, 1 - share}};
      }
      if (round == kRounds || (!both && !(cut > kTolerance * bound))) return {};
    }
  }

  /** Finds the nearest points of the mesh on both sides of a point of the edge. Along the edge, the
   *  distance from the face of `down` grows, and the distance from the face of `up` decreases. */
  void FindNearest(Vec3<Real> point, Vec3<Real> edge, Nearest<Real>& down,
                   Nearest<Real>& up) const {
    for (const Face<Real>& face : faces_) {
      Nearest<Real> nearest{std::max(down.square, up.square)};
      Approach(point, face, nearest);
      if (nearest.face == kNone) continue;
      const Vec3<Real> inwards = nearest.at.feature == kFace ? nearest.normal * -1 : nearest.offset;
      Nearest<Real>& side = Dot(inwards, edge) > 0 ? down : up;
      if (nearest.square < side.square) side = nearest;
    }
  }

  const Skin<Real>& skin_;
  std::span<const Ridge<Real>> ridges_;
  std::span<const Face<Real>> faces_;
};

}  // namespace vesper::surface_contact
