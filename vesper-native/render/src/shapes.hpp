// SPDX-License-Identifier: Apache-2.0
// The unit shapes as triangles: spheres of diameter 1 in several fineness, a cube and a square.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene.hpp"

namespace vesper::render {

struct Vertex {
  Vector3f position, normal;
  std::array<float, 2> coordinates{0, 0};  ///< in the texture, from its upper left
  std::array<float, 3> colour{1, 1, 1};    ///< linear
  uint32_t item = 0;                       ///< of a loose triangle
};

/// Counter-clockwise triangles seen from outside.
struct TriangleMesh {
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;
};

/// Geodesic sphere of diameter 1 with 20 * 4^level triangles.
TriangleMesh UnitSphere(int level);

/// Cube from -0.5 to 0.5.
TriangleMesh UnitBox();

/// Square from -0.5 to 0.5 in x and z, facing +y.
TriangleMesh UnitPlane();

/// A mesh of the stream, its triangles in their order. One with a corner that has no normal, or
/// the normal 0, is flat.
TriangleMesh ToTriangles(const Mesh& mesh);

/// Loose triangles, all flat, relative to `origin`.
TriangleMesh ToTriangles(std::span<const Triangle> triangles, const Vector3f& origin);

/// Linear value of an sRGB byte, 0 to 1.
float ToLinear(uint8_t srgb);
std::array<float, 3> ToLinear(const Colour& colour);

}  // namespace vesper::render
