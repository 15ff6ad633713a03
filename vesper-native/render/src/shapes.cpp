#include "shapes.hpp"

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

/// The 20 faces are the triples of corners that are one edge apart from each other.
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

/// Splits every triangle of a sphere in four.
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

void AddSquare(TriangleMesh& mesh, const Vector3f& centre, const Vector3f& u, const Vector3f& v) {
  const auto first = static_cast<uint32_t>(mesh.vertices.size());
  const Vector3f normal = u.cross(v).normalized();
  for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    mesh.vertices.push_back({centre + 0.5F * (a * u + b * v), normal});
  }
  for (const uint32_t corner : {0, 1, 2, 0, 2, 3}) mesh.indices.push_back(first + corner);
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
  if (!mesh.normals.empty()) {
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
      triangles.vertices.push_back({mesh.positions[i], mesh.normals[i].stableNormalized()});
    }
    triangles.indices = mesh.indices;
    return triangles;
  }
  for (size_t i = 0; i < mesh.indices.size(); i += 3) {
    const Vector3f& a = mesh.positions[mesh.indices[i]];
    const Vector3f& b = mesh.positions[mesh.indices[i + 1]];
    const Vector3f& c = mesh.positions[mesh.indices[i + 2]];
    const Vector3f normal =
        (b - a).stableNormalized().cross((c - a).stableNormalized()).stableNormalized();
    for (const Vector3f* corner : {&a, &b, &c}) {
      triangles.indices.push_back(static_cast<uint32_t>(triangles.vertices.size()));
      triangles.vertices.push_back({*corner, normal});
    }
  }
  return triangles;
}

}  // namespace vesper::render
