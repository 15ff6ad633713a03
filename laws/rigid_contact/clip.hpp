// SPDX-License-Identifier: Apache-2.0
// Contact points of two faces, by clipping one face at the sides of the other.
#pragma once

#include "manifold.hpp"

namespace vesper::rigid {

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

/** A face that is clipped at the sides of a flat polygon, the reference. */
struct Clipping {
  const Face& reference;  // counter-clockwise around the normal
  Vector normal;          // of the reference face, towards the clipped face
  const Face& incident;
  double radius;  // radius by which the clipped face's shape is rounded [m]
  double inset;   // radius by which the reference's shape is rounded [m]
  double margin;  // as in Meeting [m]
};

/** Adds the points of the clipped face that are less than the margin above the reference. */
void AddClipped(const Clipping& clipping, Manifold& manifold);

}  // namespace vesper::rigid
