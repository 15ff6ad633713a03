// SPDX-License-Identifier: Apache-2.0
// The forces of a contact.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "skin.hpp"

namespace vesper::surface_contact {

template <class Real>
Vec3<Real> Across(Vec3<Real> v, Vec3<Real> normal) {
  return v - normal * Dot(v, normal);
}

/// Contact parameters of the touched surface.
template <class Real>
struct Material {
  Real hardness = 0;  // [N/m]
  Real damping = 0;   // [N s/m]
  Real friction = 0;  // [1]
};

/** A point attached to a face: weights of the corners, and a height above the plane of the face. */
template <class Real>
struct Frame {
  Frame(const std::array<Vec3<Real>, 3>& corners, Vec3<Real> point) {
    const auto& [a, b, c] = corners;
    const Vec3<Real> cross = Cross(b - a, c - a);
    const Real area = Dot(cross, cross);
    normal = cross * (1 / std::sqrt(area));
    gradients = {Cross(cross, c - b) * (1 / area), Cross(cross, a - c) * (1 / area),
                 Cross(cross, b - a) * (1 / area)};
    height = Dot(normal, point - a);
    weights[1] = Dot(gradients[1], point - a);
    weights[2] = Dot(gradients[2], point - a);
    weights[0] = 1 - weights[1] - weights[2];
  }

  /** Returns the velocity of the face's material at the point. */
  Vec3<Real> Carried(const std::array<Vec3<Real>, 3>& moving) const {
    Vec3<Real> sum = Blend(weights, moving);
    for (int i = 0; i < 3; ++i) sum -= gradients[i] * (height * Dot(normal, moving[i]));
    return sum;
  }

  /** Returns the reaction on a corner of the face to a force on the point. The sum of the reactions
   *  on all corners is opposite to the force, and so is their moment. Their power is minus the
   *  force times Carried. */
  Vec3<Real> Reaction(int corner, Vec3<Real> on_point) const {
    return on_point * -weights[corner] + normal * (height * Dot(gradients[corner], on_point));
  }

  Vec3<Real> normal;
  std::array<Vec3<Real>, 3> gradients;  // gradients of the weights [1/m]
  std::array<Real, 3> weights;
  Real height;
};

/// A point that penetrates n faces of a mesh.
template <class Real, size_t n>
struct Touch {
  Vec3<Real> point;     // [m]
  Vec3<Real> velocity;  // velocity of the point [m/s]
  std::array<Immersion<Real>, n> faces;
  std::array<Real, n> shares;  // weights of the n faces; their sum is 1
  Real depth;                  // depth, weighted by shares [m]
  Real strength;               // factor for hardness and damping, 0 to 1

  /// Returns the normal. For one face its length is 1. For two faces it is the weighted mean of
  /// their normals, and therefore shorter.
  Vec3<Real> Normal() const {
    if constexpr (n == 1) return faces[0].normal;
    Vec3<Real> sum;
    for (size_t i = 0; i < n; ++i) sum += faces[i].normal * shares[i];
    return sum;
  }
};

/// Forces of a contact [N].
template <class Real>
struct Response {
  Real push = 0;      // along the normal of the contact
  Vec3<Real> drag{};  // tangential force on the point
};

/** Returns the friction force on a point [N]. It is the force of a spring with the elongation
 *  `stretch` and of a damper of the slip, limited by Coulomb's law (P. A. Cundall, O. D. L. Strack,
 *  A Discrete Numerical Model for Granular Assemblies, 1979). */
template <class Real>
Vec3<Real> Rub(const Material<Real>& skin, Vec3<Real> slip, Real limit, Vec3<Real>& stretch) {
  Vec3<Real> drag = stretch * -skin.hardness - slip * skin.damping;
  const Real size = Length(drag);
  if (!(size <= limit)) {
    drag = drag * (limit / size);
    stretch =
        skin.hardness > 0 ? (drag + slip * skin.damping) * (-1 / skin.hardness) : Vec3<Real>{};
  }
  return drag;
}

}  // namespace vesper::surface_contact
