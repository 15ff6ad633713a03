// SPDX-License-Identifier: Apache-2.0
#include "shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace vesper::render {

namespace {

std::vector<Vector3f> IcosahedronCorners() {
  const float golden = (1 + std::sqrt(5.0F)) / 2;
  std::vector<Vector3f> corners;
  for (const float one : {-1.0F, 1.0F}) {
    for (const float phi : {-golden, golden}) {
      corners.push_back(Vector3f(0, one, phi).normalized());
      corners.push_back(Vector3f(one, phi, 0).normalized());
      corners.push_back(Vector3f(phi, 0, one).normalized());
    }
  }
  return corners;
}

/// Returns the 20 faces of an icosahedron. The faces are all triples of corners in which each pair
/// of corners has an edge.
std::vector<uint32_t> IcosahedronFaces(const std::vector<Vector3f>& corners) {
  const auto adjacent = [&](uint32_t a, uint32_t b) {
    return (corners[a] - corners[b]).norm() < 1.1F;
  };
  std::vector<uint32_t> faces;
  for (uint32_t a = 0; a < corners.size(); ++a) {
    for (uint32_t b = a + 1; b < corners.size(); ++b) {
      for (uint32_t c = b + 1; c < corners.size(); ++c) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(a, c)) continue;
        const Vector3f normal = (corners[b] - corners[a]).cross(corners[c] - corners[a]);
        const bool outward = normal.dot(corners[a]) > 0;
        faces.insert(faces.end(), {a, outward ? b : c, outward ? c : b});
      }
    }
  }
  return faces;
}

/// Splits every triangle of a sphere into four triangles.
void Refine(std::vector<Vector3f>& corners, std::vector<uint32_t>& faces) {
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
  const auto middle = [&](uint32_t a, uint32_t b) {
    const auto [found, added] = middles.try_emplace(std::minmax(a, b), corners.size());
    if (added) corners.push_back((corners[a] + corners[b]).normalized());
    return found->second;
  };
  std::vector<uint32_t> fine;
  fine.reserve(faces.size() * 4);
  for (size_t i = 0; i < faces.size(); i += 3) {
    const uint32_t a = faces[i], b = faces[i + 1], c = faces[i + 2];
    const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.insert(fine.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
  }
  faces = std::move(fine);
}

/// Adds a square with an upright texture. The top of the texture of a horizontal square is towards
/// -z.
void AddSquare(TriangleMesh& mesh, const Vector3f& centre, const Vector3f& u, const Vector3f& v) {
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  const Vector3f normal = u.cross(v).normalized();
  const Vector3f up = normal.y() != 0 ? Vector3f(0, 0, -normal.y()) : Vector3f::UnitY();
  const Vector3f right = up.cross(normal);
  for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const Vector3f at = centre + 0.5F * (a * u + b * v);
    mesh.vertices.push_back({at, normal, {0.5F + at.dot(right), 0.5F - at.dot(up)}});
  }
  for (const uint32_t corner : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + corner);
}

Vector3f FlatNormal(const Vector3f& a, const Vector3f& b, const Vector3f& c) {
  return (b - a).stableNormalized().cross((c - a).stableNormalized()).stableNormalized();
}

Vertex ToVertex(const Mesh& mesh, size_t i) {
  Vertex vertex{mesh.positions[i], Vector3f::Zero()};
  if (!mesh.normals.empty()) vertex.normal = mesh.normals[i].stableNormalized();
  if (!mesh.coordinates.empty()) vertex.coordinates = mesh.coordinates[i];
  if (!mesh.colours.empty()) vertex.colour = ToLinear(mesh.colours[i]);
  return vertex;
}

}  // namespace

TriangleMesh UnitSphere(int level) {
  std::vector<Vector3f> corners = IcosahedronCorners();
  TriangleMesh mesh;
  mesh.indices = IcosahedronFaces(corners);
  for (int i = 0; i < level; ++i) Refine(corners, mesh.indices);
  for (const Vector3f& corner : corners) mesh.vertices.push_back({corner * 0.5F, corner});
  return mesh;
}

TriangleMesh UnitBox() {
  TriangleMesh mesh;
  const std::array<Vector3f, 3> axes{Vector3f::UnitX(), Vector3f::UnitY(), Vector3f::UnitZ()};
  for (size_t i = 0; i < 3; ++i) {
    const Vector3f &n = axes[i], &u = axes[(i + 1) % 3], &v = axes[(i + 2) % 3];
    AddSquare(mesh, 0.5F * n, u, v);
    AddSquare(mesh, -0.5F * n, v, u);
  }
  return mesh;
}

TriangleMesh UnitPlane() {
  TriangleMesh mesh;
  AddSquare(mesh, Vector3f::Zero(), Vector3f::UnitZ(), Vector3f::UnitX());
  return mesh;
}

TriangleMesh ToTriangles(const Mesh& mesh) {
  TriangleMesh triangles;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    triangles.vertices.push_back(ToVertex(mesh, i));
  }
  const auto has_normal = [](const Vertex& vertex) { return vertex.normal.squaredNorm() > 0; };
  if (std::ranges::all_of(triangles.vertices, has_normal)) {
    triangles.indices = mesh.indices;
    return triangles;
  }
  const std::vector<Vertex> shared = std::move(triangles.vertices);
  triangles.vertices.clear();
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    std::array<Vertex, 3> corners{shared[mesh.indices[i]], shared[mesh.indices[i + 1]],
                                  shared[mesh.indices[i + 2]]};
    const bool flat = !std::ranges::all_of(corners, has_normal);
    const Vector3f normal =
        FlatNormal(corners[0].position, corners[1].position, corners[2].position);
    for (Vertex& corner : corners) {
      if (flat) corner.normal = normal;
      triangles.indices.push_back(static_cast<uint32_t>(triangles.vertices.size()));
      triangles.vertices.push_back(corner);
    }
  }
  return triangles;
}

TriangleMesh ToTriangles(std::span<const Triangle> triangles, const Vector3f& origin) {
  TriangleMesh mesh;
  mesh.vertices.reserve(triangles.size() * 3);
  for (const Triangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.corners;
    const Vector3f normal = FlatNormal(a, b, c);
    for (size_t corner = 0; corner < 3; ++corner) {
      mesh.indices.push_back(static_cast<uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back({triangle.corners[corner] - origin,
                               normal,
                               {0, 0},
                               ToLinear(triangle.colours[corner]),
                               triangle.item});
    }
  }
  return mesh;
}

float ToLinear(uint8_t srgb) {
  static const auto table = [] {
    std::array<float, 256> values;
    for (size_t i = 0; i < values.size(); ++i) {
      const double s = static_cast<double>(i) / 255;
      values[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return values;
  }();
  return table[srgb];
}

std::array<float, 3> ToLinear(const Colour& colour) {
  return {ToLinear(colour[0]), ToLinear(colour[1]), ToLinear(colour[2])};
}

}  // namespace vesper::render
