// SPDX-License-Identifier: Apache-2.0
// The regular icosahedron with corners at distance 1 m from its centre, for tests and benchmarks.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vesper::icosahedron {

inline double HalfEdge() { return std::sqrt((5 - std::sqrt(5.0)) / 10); }
/// Returns the distance from the centre to the middle of an edge [m].
inline double Midsphere() { return std::sqrt((5 + std::sqrt(5.0)) / 10); }
/// Returns the distance from the centre to the middle of a face [m].
inline double Insphere() { return std::sqrt((5 + 2 * std::sqrt(5.0)) / 15); }

/// Corners of the faces, counter-clockwise as seen from outside.
inline constexpr std::array<std::array<uint32_t, 3>, 20> kFaces = {
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

/// Returns the positions of the corners (12 x 3) [m].
inline std::array<std::array<double, 3>, 12> Corners() {
  const double s = HalfEdge(), l = Midsphere();
  return {{{-s, l, 0},
           {s, l, 0},
           {-s, -l, 0},
           {s, -l, 0},
           {0, -s, l},
           {0, s, l},
           {0, -s, -l},
           {0, s, -l},
           {l, 0, -s},
           {l, 0, s},
           {-l, 0, -s},
           {-l, 0, s}}};
}

/// Returns pairs of corners, the lower one first, in the order of their faces.
constexpr std::array<std::array<uint32_t, 2>, 30> Edges() {
  std::array<std::array<uint32_t, 2>, 30> edges{};
  size_t count = 0;
  for (const auto& face : kFaces) {
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = face[i], b = face[(i + 1) % 3];
      if (a < b) edges[count++] = {a, b};  // otherwise the neighbouring face adds this edge
    }
  }
  return edges;
}

}  // namespace vesper::icosahedron
