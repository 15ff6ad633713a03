// SPDX-License-Identifier: Apache-2.0
// The instances of a picture, sorted by the mesh that shows them and ready for the graphics memory.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <vector>

#include "scene.hpp"
#include "view.hpp"

namespace vesper::render {

/// One instance as the vertex shader reads it.
struct InstanceRecord {
  std::array<float, 12> model;  ///< 3 x 4, by rows: unit shape to the camera's target frame
  std::array<float, 3> colour;  ///< linear
  uint32_t flags;               ///< ItemFlags
  uint32_t item;                ///< 0 for loose triangles: their corners know
};
static_assert(sizeof(InstanceRecord) == 68);

inline constexpr int kCoarsestSphere = 0, kFinestSphere = 5;

/// Triangles in graphics memory: `detail` is the level of a sphere or the id of a mesh, else 0.
struct MeshKey {
  Shape shape;
  uint64_t detail;
  auto operator<=>(const MeshKey&) const = default;
};

/// Detail of the mesh that holds a picture's loose triangles; beyond all ids.
inline constexpr uint64_t kLooseTriangles = uint64_t{1} << 32;

/// What one draw shows: instances of a mesh, or of some of its triangles, in one material.
struct DrawKey {
  MeshKey mesh;
  uint32_t material, first_triangle, triangle_count;  ///< count 0: all
  auto operator<=>(const DrawKey&) const = default;
};

using DrawList = std::map<DrawKey, std::vector<InstanceRecord>>;

/// Balls around everything that the scene shows.
Extent Measure(const Scene& scene);

/// Refills `list`, keeping its memory. Spheres get as many triangles as their size in pixels asks
/// for; what has no size at all is left out.
void Sort(const Scene& scene, const View& view, DrawList& list);

}  // namespace vesper::render
