// SPDX-License-Identifier: Apache-2.0
// Contact points of two faces by clipping one at the sides of the other.
#pragma once

#include "manifold.hpp"

namespace vesper::rigid {

/** Two shapes and the direction from the first to the second along which they touch. */
struct Meeting {
  const Shape& a;
  const Shape& b;
  Vector normal;
  double margin;  // greatest separation of a contact point [m]
};

/** Adds the points of the faces of two shapes that touch along the normal. Adds nothing if neither
 *  has a face across the normal. */
void ClipFaces(const Meeting& meeting, Manifold& manifold);

/** A face that is clipped at the sides of a flat polygon, the reference. */
struct Clipping {
  const Face& reference;  // counter-clockwise around the normal
  Vector normal;          // of the reference, towards the face
  const Face& incident;
  double radius;  // of the shape of the face [m]
  double inset;   // distance from the corners of the reference to its surface [m]
  double margin;  // [m]
};

/** Adds the points of the clipped face that are less than the margin above the reference. */
void AddClipped(const Clipping& clipping, Manifold& manifold);

}  // namespace vesper::rigid
