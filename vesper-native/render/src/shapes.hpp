// The unit shapes as triangles: spheres of diameter 1 in several fineness, a cube and a square.
#pragma once

#include <cstdint>
#include <vector>

#include "scene.hpp"

namespace vesper::render {

struct Vertex {
  Vector3f position, normal;
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

/// A mesh of the stream; where it has no normals every triangle gets its own.
TriangleMesh ToTriangles(const Mesh& mesh);

}  // namespace vesper::render
