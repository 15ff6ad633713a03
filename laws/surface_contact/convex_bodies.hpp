// SPDX-License-Identifier: Apache-2.0
// Convex meshes of springs for tests, and the penetration depth of two of them.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <random>
#include <vector>

#include "contact_scene.hpp"

namespace vesper {

/// Corners [m] about a centre, and faces, counter-clockwise as seen from outside.
struct ConvexBody {
  std::vector<Vec3<double>> corners;
  std::vector<std::array<uint32_t, 3>> faces;
};

inline Vec3<double> Unit(Vec3<double> v) { return v * (1 / Length(v)); }

/// Returns a tetrahedron. One edge is along x at y = h, and another edge is along z at y = -h, with
/// h = edge / sqrt(8).
inline ConvexBody Tetrahedron(double edge) {
  const double s = edge / 2, h = edge / std::sqrt(8.0);
  return {{{-s, h, 0}, {s, h, 0}, {0, -h, -s}, {0, -h, s}},
          {{0, 1, 2}, {1, 0, 3}, {2, 3, 0}, {3, 2, 1}}};
}

inline ConvexBody Box(Vec3<double> half) {
  ConvexBody box;
  for (int i = 0; i < 8; ++i) {
    box.corners.push_back(
        {i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z});
  }
  box.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
               {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return box;
}

inline ConvexBody Octahedron() {
  ConvexBody body{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, {}};
  for (int i = 0; i < 8; ++i) {
    const uint32_t x = i & 1, y = 2 + (i >> 1 & 1), z = 4 + (i >> 2 & 1);
    if ((x + y + z) % 2 == 0) {
      body.faces.push_back({x, y, z});
    } else {
      body.faces.push_back({y, x, z});
    }
  }
  return body;
}

/// Returns the body, rotated by a unit quaternion (x, y, z, w).
inline ConvexBody Turned(ConvexBody body, std::array<double, 4> q) {
  const Vec3<double> axis{q[0], q[1], q[2]};
  for (auto& p : body.corners) {
    const Vec3<double> twice = Cross(axis, p) * 2.0;
    p = p + twice * q[3] + Cross(axis, twice);
  }
  return body;
}

/// A source of random numbers for the tests. The numbers are the same with every standard library.
class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}

  double Between(double low, double high) { return low + (high - low) * engine_() / 4294967296.0; }
  Vec3<double> Direction() {
    for (;;) {
      const Vec3<double> v{Between(-1, 1), Between(-1, 1), Between(-1, 1)};
      if (const double length = Length(v); length > 0.1 && length < 1) return v * (1 / length);
    }
  }
  /// Returns a tetrahedron, box or octahedron, scaled along three axes and rotated; its corners are
  /// between 0.3 m and 1.3 m from its centre.
  ConvexBody Body() {
    ConvexBody body;
    switch (engine_() % 3) {
      case 0:
        body = Tetrahedron(1.6);
        break;
      case 1:
        body = Box({0.55, 0.55, 0.55});
        break;
      default:
        body = Octahedron();
    }
    const Vec3<double> size{Between(0.8, 1.3), Between(0.8, 1.3), Between(0.8, 1.3)};
    for (auto& p : body.corners) p = {p.x * size.x, p.y * size.y, p.z * size.z};
    const Vec3<double> axis = Direction();
    const double half = Between(0, std::numbers::pi);
    return Turned(body, {axis.x * std::sin(half), axis.y * std::sin(half), axis.z * std::sin(half),
                         std::cos(half)});
  }

 private:
  std::mt19937 engine_;
};

/// Adds a body with springs between all its corners; returns the rows of its bodies.
template <class Real>
Rows AddBody(ContactScene<Real>& scene, const ConvexBody& body, Vec3<double> centre,
             Vec3<double> speed, const Frame& frame, const Material& material) {
  const auto narrow = [](Vec3<double> v) {
    return Vec3<Real>{static_cast<Real>(v.x), static_cast<Real>(v.y), static_cast<Real>(v.z)};
  };
  const auto first = static_cast<uint32_t>(scene.mass.size());
  const auto count = static_cast<uint32_t>(body.corners.size());
  for (const auto& p : body.corners) {
    scene.AddBody(static_cast<Real>(frame.mass), narrow(centre + p), narrow(speed));
  }
  for (uint32_t i = 0; i < count; ++i) {
    for (uint32_t j = i + 1; j < count; ++j) {
      const double length = Length(body.corners[i] - body.corners[j]);
      scene.AddSpring(first + i, first + j, static_cast<Real>(length),
                      static_cast<Real>(frame.hooke), static_cast<Real>(frame.damping));
    }
  }
  for (const auto& [a, b, c] : body.faces) {
    scene.AddSurface({first + a, first + b, first + c}, material);
  }
  return {first, count};
}

/** Returns the penetration depth of two convex bodies [m]. It is the least overlap over the normals
 *  of all faces and the cross products of edges. If it is negative, the bodies are apart, at least
 *  by this amount. `first` and `second` are the current corners. */
inline double Overlap(const std::vector<Vec3<double>>& first, const ConvexBody& first_shape,
                      const std::vector<Vec3<double>>& second, const ConvexBody& second_shape) {
  std::vector<Vec3<double>> directions;
  const auto edges = [&](const auto& corners, const ConvexBody& shape) {
    std::vector<Vec3<double>> along;
    for (const auto& [a, b, c] : shape.faces) {
      directions.push_back(Cross(corners[b] - corners[a], corners[c] - corners[a]));
      for (const auto& [i, j] : {std::pair{a, b}, {b, c}, {c, a}}) {
        if (i < j) along.push_back(corners[j] - corners[i]);
      }
    }
    return along;
  };
  const auto of_first = edges(first, first_shape), of_second = edges(second, second_shape);
  for (const auto& u : of_first) {
    for (const auto& v : of_second) directions.push_back(Cross(u, v));
  }
  double overlap = std::numeric_limits<double>::max();
  for (const auto& direction : directions) {
    if (Length(direction) < 1e-9) continue;
    const Vec3<double> n = Unit(direction);
    const auto along = [&](Vec3<double> p) { return Dot(n, p); };
    const auto [a0, a1] = std::ranges::minmax(first, {}, along);
    const auto [b0, b1] = std::ranges::minmax(second, {}, along);
    overlap = std::min({overlap, along(a1) - along(b0), along(b1) - along(a0)});
  }
  return overlap;
}

}  // namespace vesper
