// SPDX-License-Identifier: Apache-2.0
// The instances of a picture, sorted by mesh, in the layout of the graphics memory.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <vector>

#include "scene.hpp"
#include "view.hpp"

namespace vesper::render {

/// One instance in the layout of the vertex shader.
struct InstanceRecord {
  std::array<float, 12> model;  ///< 3 x 4, row-major: from the unit shape to axes at the camera's
                                ///< target
  std::array<float, 3> colour;  ///< linear
  uint32_t flags;               ///< ItemFlags
  uint32_t item;                ///< 0 for loose triangles, whose item is stored per corner
};
static_assert(sizeof(InstanceRecord) == 68);

inline constexpr int kCoarsestSphere = 0, kFinestSphere = 5;

/// Key of a set of triangles in graphics memory. `detail` is the level of a sphere, the id of a
/// mesh, or 0.
struct MeshKey {
  Shape shape;
  uint64_t detail;
  auto operator<=>(const MeshKey&) const = default;
};

/// The value of `detail` in the MeshKey of loose triangles, which belong to no mesh. The ids of
/// meshes have 32 bits, so no id is equal to this value.
inline constexpr uint64_t kLooseTriangles = uint64_t{1} << 32;

/// Key of one draw: instances of a mesh, or of a part of its triangles, in one material.
struct DrawKey {
  MeshKey mesh;
  uint32_t material, first_triangle, triangle_count;  ///< count 0: all triangles
  auto operator<=>(const DrawKey&) const = default;
};

using DrawList = std::map<DrawKey, std::vector<InstanceRecord>>;

/// Returns balls that contain the items of the scene.
Extent Measure(const Scene& scene);

/// Replaces the content of `list`; reuses its memory. The number of triangles of a sphere depends
/// on its size in pixels. Items of size zero are omitted.
void Sort(const Scene& scene, const View& view, DrawList& list);

}  // namespace vesper::render
