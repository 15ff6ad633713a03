// SPDX-License-Identifier: Apache-2.0
// The deepest point of an edge behind another mesh.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "skin.hpp"

namespace vesper::surface_contact {

/// Two faces that meet in a convex edge: behind it an edge of another mesh may be deepest.
template <class Real>
struct Ridge {
  Vec3<Real> start;
  Vec3<Real> along;                   // the edge, over the square of its length [1/m]
  std::array<Vec3<Real>, 2> normals;  // of the faces, outwards, length 1
};

/// Where an edge is deepest behind a mesh: as far behind a face that lies ahead as behind one that
/// lies back.
template <class Real>
struct DeepestPoint {
  Real depth = 0;                          // [m]; 0: the edge is nowhere deeper than it had to be
  Real place = 0;                          // along the edge, from 0 to 1
  std::array<Immersion<Real>, 2> faces{};  // of this point
  std::array<Real, 2> shares{};  // of the faces in `depth`; so weighted, their normals are across
                                 // the edge
};

/** Looks for the deepest point of an edge behind a mesh that has these ridges and faces. Along the
 *  edge, the depth behind a convex part of a mesh is the least of its depths below the faces'
 *  planes: the search cuts down to it plane by plane (J. E. Kelley, The Cutting-Plane Method for
 *  Solving Convex Programs, 1960), from where the planes of each ridge meet. */
template <class Real>
class DeepestPointSearch {
 public:
  DeepestPointSearch(const Skin<Real>& skin, std::span<const Ridge<Real>> ridges,
                     std::span<const Face<Real>> faces)
      : skin_(skin), ridges_(ridges), faces_(faces) {}

  /** Of the edge from `start` to `end`, if deeper than `least` and less deep than `most` [m]. */
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
  /// Of a depth; where planes cut off no more, it is found.
  static constexpr Real kTolerance = Real(1e-4);

  /// A depth below a plane along the edge: at its start, and how it grows to the end [m].
  struct Slope {
    Real at_start, growth;
    Real At(Real place) const { return at_start + place * growth; }
  };
  /// Of a plane that the edge goes down from and of one that it comes up to.
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

  /** The nearest points of the mesh from which the edge goes down, and to which it comes up. */
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
