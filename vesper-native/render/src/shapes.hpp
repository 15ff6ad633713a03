// SPDX-License-Identifier: Apache-2.0
// The unit shapes as triangles: spheres of diameter 1 at several levels of detail, a cube and a
// square.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene.hpp"

namespace vesper::render {

struct Vertex {
  Vector3f position, normal;
  std::array<float, 2> coordinates{0, 0};  ///< texture coordinates; (0, 0) is the upper left
  std::array<float, 3> colour{1, 1, 1};    ///< linear
  uint32_t item = 0;                       ///< item of a loose triangle; otherwise 0
};

/// Triangles whose corners run counter-clockwise as seen from outside.
struct TriangleMesh {
  std::vector<Vertex> vertices;
  std::vector<uint32_t> indices;
};

/// Returns a geodesic sphere of diameter 1 with 20 * 4^level triangles.
TriangleMesh UnitSphere(int level);

/// Returns a cube from -0.5 to 0.5.
TriangleMesh UnitBox();

/// Returns a square from -0.5 to 0.5 in x and z, facing +y.
TriangleMesh UnitPlane();

/// Converts a mesh of the scene stream; the triangles keep their order. A triangle gets flat
/// shading if one of its corners has no normal, or the normal 0.
TriangleMesh ToTriangles(const Mesh& mesh);

/// Converts loose triangles (triangles of no mesh). They all get flat shading, and their positions
/// become relative to `origin`.
TriangleMesh ToTriangles(std::span<const Triangle> triangles, const Vector3f& origin);

/// Returns the linear value of an sRGB byte, 0 to 1.
float ToLinear(uint8_t srgb);
std::array<float, 3> ToLinear(const Colour& colour);

}  // namespace vesper::render
