// SPDX-License-Identifier: Apache-2.0
// Contact points of two faces, by clipping one face at the sides of the other.
#pragma once

#include <span>

#include "manifold.hpp"

namespace vesper::rigid {

// Cosine of the greatest angle between the contact normal and the normal of a face at which the
// face counts as touching. With a larger angle, only an edge or a corner of the face touches.
inline constexpr double kFlat = 0.985;

/** Returns the unit normal of a face; 0 if its corners lie on a line. */
Vector NormalOf(const Face& face);

/** Two shapes and their contact normal, which points from the first to the second. */
struct Meeting {
  const Shape& a;
  const Shape& b;
  Vector normal;
  double margin;  // greatest separation at which points are contact points [m]
};

/** Adds the contact points of the two faces that touch. Adds nothing if neither shape has a face
 *  perpendicular to the normal. */
void ClipFaces(const Meeting& meeting, Manifold& manifold);

/** Adds at most four of the points `found`: the deepest point, and the points that span the largest
 *  area with it. */
void Choose(std::span<const ContactPoint> found, const Vector& normal, Manifold& manifold);

/** Adds at most four of the points `found`, as Choose does. Small changes of the points do not
 *  change the choice, because a changing choice would disturb resting bodies with many points. */
void ChooseSteadily(std::span<const ContactPoint> found, const Vector& normal, Manifold& manifold);

/** A face that is clipped at the sides of a flat polygon, the reference. */
struct Clipping {
  const Face& reference;  // counter-clockwise around the normal
  Vector normal;          // normal of the reference, towards the clipped face
  const Face& incident;
  double radius;        // radius by which the clipped face's shape is rounded [m]
  double inset;         // radius by which the reference's shape is rounded [m]
  double margin;        // greatest separation, see Meeting [m]
  bool steady = false;  // chooses points by ChooseSteadily
};

/** Adds the points of the clipped face that are less than the margin above the reference. */
void AddClipped(const Clipping& clipping, Manifold& manifold);

}  // namespace vesper::rigid
