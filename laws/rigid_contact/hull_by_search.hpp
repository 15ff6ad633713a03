// SPDX-License-Identifier: Apache-2.0
// Convex hulls for tests, found by a search through all triples of points. The search is
// independent of the code with which worlds compute hulls.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "rigid/rotation.hpp"

namespace vesper {

/// The hull of a few points, in the form of the columns of meshes.
struct HullBySearch {
  using Vector = Vec3<double>;

  std::vector<Vector> corners, core, normals;
  std::vector<std::vector<int32_t>> faces;
  std::vector<double> offsets;
  double thickness = HUGE_VAL;

  explicit HullBySearch(const std::vector<Vector>& points) : corners(points) {
    const auto n = int32_t(points.size());
    for (int32_t a = 0; a < n; ++a) {
      for (int32_t b = 0; b < n; ++b) {
        for (int32_t c = 0; c < n; ++c) {
          if (a != b && b != c && c != a) TryFace(a, b, c);
        }
      }
    }
    for (const Vector& normal : normals) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (const Vector& p : points) {
        low = std::min(low, Dot(p, normal));
        high = std::max(high, Dot(p, normal));
      }
      thickness = std::min(thickness, high - low);
    }
    FindCore();
  }

  /// Returns the triangles of the faces.
  std::vector<int32_t> Triangles() const {
    std::vector<int32_t> triangles;
    for (const auto& face : faces) {
      for (size_t i = 2; i < face.size(); ++i) {
        triangles.insert(triangles.end(), {face[0], face[i - 1], face[i]});
      }
    }
    return triangles;
  }

 private:
  void TryFace(int32_t a, int32_t b, int32_t c) {
    const Vector way = Cross(corners[b] - corners[a], corners[c] - corners[a]);
    const double length = Length(way);
    if (length < 1e-9) return;
    const Vector normal = way * (1 / length);
    const double offset = Dot(normal, corners[a]);
    std::vector<int32_t> face;
    Vector centre;
    for (int32_t i = 0; i < int32_t(corners.size()); ++i) {
      const double height = Dot(normal, corners[i]) - offset;
      if (height > 1e-9) return;
      if (height > -1e-9) {
        face.push_back(i);
        centre += corners[i];
      }
    }
    for (size_t i = 0; i < normals.size(); ++i) {
      if (Dot(normals[i], normal) > 1 - 1e-9 && std::abs(offsets[i] - offset) < 1e-9) return;
    }
    centre = centre * (1.0 / double(face.size()));
    const Vector u = corners[face[0]] - centre, v = Cross(normal, u);
    std::sort(face.begin(), face.end(), [&](int32_t x, int32_t y) {
      const Vector p = corners[x] - centre, q = corners[y] - centre;
      return std::atan2(Dot(p, v), Dot(p, u)) < std::atan2(Dot(q, v), Dot(q, u));
    });
    normals.push_back(normal);
    offsets.push_back(offset);
    faces.push_back(face);
  }

  /// Finds the corners of the core. All faces are moved inwards by 5 % of the thickness; the
  /// corners are the points in which three of these faces meet.
  void FindCore() {
    const double inset = 0.05 * thickness;
    const size_t n = normals.size();
    for (size_t a = 0; a < n; ++a) {
      for (size_t b = a + 1; b < n; ++b) {
        for (size_t c = b + 1; c < n; ++c) {
          const Vector ab = Cross(normals[a], normals[b]), bc = Cross(normals[b], normals[c]),
                       ca = Cross(normals[c], normals[a]);
          const double determinant = Dot(ab, normals[c]);
          if (std::abs(determinant) < 1e-6) continue;
          const Vector at =
              (bc * (offsets[a] - inset) + ca * (offsets[b] - inset) + ab * (offsets[c] - inset)) *
              (1 / determinant);
          bool inside = true;
          for (size_t i = 0; i < n; ++i) {
            inside = inside && Dot(normals[i], at) < offsets[i] - inset + 1e-9;
          }
          if (inside) core.push_back(at);
        }
      }
    }
  }
};

/// Returns the corners of a box.
inline std::vector<Vec3<double>> BoxCorners(Vec3<double> size) {
  std::vector<Vec3<double>> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(
        {size.x * ((i & 1) - 0.5), size.y * ((i >> 1 & 1) - 0.5), size.z * ((i >> 2) - 0.5)});
  }
  return corners;
}

}  // namespace vesper
