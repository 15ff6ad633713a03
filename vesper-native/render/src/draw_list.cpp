// SPDX-License-Identifier: Apache-2.0
#include "draw_list.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "shapes.hpp"

namespace vesper::render {

namespace {

/// Returns the radius of a ball around the origin that contains the mesh.
float Reach(const Mesh& mesh) {
  float reach = 0;
  for (const Vector3f& position : mesh.positions) reach = std::max(reach, position.norm());
  return reach;
}

float Radius(Shape shape, const Vector3f& size, float mesh_reach) {
  switch (shape) {
    case Shape::kSphere:
      return size.maxCoeff() / 2;
    case Shape::kBox:
      return size.norm() / 2;
    case Shape::kPlane:
      return std::hypot(size.x(), size.z()) / 2;
    case Shape::kMesh:
      return size.maxCoeff() * mesh_reach;
  }
  return 0;
}

/// Returns the level of detail of the coarsest sphere whose outline deviates from a circle by at
/// most a quarter of a pixel.
uint32_t SphereLevel(float radius_pixels) {
  // This variable is the maximum radius of a level [px]. Each level divides the deviation by four,
  // so the radius may be four times as large as that of the level before.
  float reach = 1.5F;
  int level = kCoarsestSphere;
  for (; level < kFinestSphere && radius_pixels > reach; ++level) reach *= 4;
  return static_cast<uint32_t>(level);
}

InstanceRecord ToRecord(const Instance& instance, Shape shape, const Vector3f& origin) {
  // The shader divides by the sizes to transform normals, so no size may be exactly 0.
  Vector3f size = instance.size.cwiseMax(1e-6F * instance.size.maxCoeff());
  if (shape == Shape::kPlane) size.y() = size.maxCoeff();
  const Eigen::Matrix3f turn = instance.orientation.normalized().toRotationMatrix();
  const Vector3f position = instance.position - origin;
  InstanceRecord record;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      record.model[row * 4 + column] = turn(row, column) * size[column];
    }
    record.model[row * 4 + 3] = position[row];
  }
  record.colour = ToLinear(instance.colour);
  record.flags = instance.flags;
  record.item = instance.item;
  return record;
}

}  // namespace

Extent Measure(const Scene& scene) {
  Extent extent;
  for (const InstanceBatch& batch : scene.batches) {
    const float reach = batch.shape == Shape::kMesh ? Reach(scene.meshes.at(batch.mesh)) : 0;
    for (const Instance& instance : batch.instances) {
      const Ball ball{instance.position - scene.camera.target,
                      Radius(batch.shape, instance.size, reach)};
      if (batch.shape == Shape::kPlane) {
        if (instance.flags & kFade)
          extent.fades = true;
        else
          extent.planes.push_back(ball);
        continue;
      }
      extent.items.push_back(ball);
      if (!(instance.flags & kUnlit)) extent.casters.push_back(ball);
    }
  }
  for (const Segment& segment : scene.segments) {
    extent.items.push_back({segment.from - scene.camera.target, 0});
    extent.items.push_back({segment.to - scene.camera.target, 0});
  }
  for (const Triangle& triangle : scene.triangles) {
    const auto& [a, b, c] = triangle.corners;
    const Vector3f centre = a / 3 + b / 3 + c / 3;
    const float radius = std::max({(a - centre).norm(), (b - centre).norm(), (c - centre).norm()});
    extent.items.push_back({centre - scene.camera.target, radius});
    extent.casters.push_back(extent.items.back());
  }
  return extent;
}

void Sort(const Scene& scene, const View& view, DrawList& list) {
  for (auto& [key, records] : list) records.clear();
  for (const InstanceBatch& batch : scene.batches) {
    const auto key = [&batch](uint32_t detail) {
      return DrawKey{
          {batch.shape, detail}, batch.material, batch.first_triangle, batch.triangle_count};
    };
    std::array<std::vector<InstanceRecord>*, kFinestSphere + 1> spheres{};
    std::vector<InstanceRecord>* const others =
        batch.shape == Shape::kSphere ? nullptr
                                      : &list[key(batch.shape == Shape::kMesh ? batch.mesh : 0)];
    for (const Instance& instance : batch.instances) {
      if (!(instance.size.maxCoeff() > 0)) continue;
      const InstanceRecord record = ToRecord(instance, batch.shape, view.origin());
      if (others != nullptr) {
        others->push_back(record);
        continue;
      }
      const float radius = instance.size.maxCoeff() / 2;
      const Ball ball{instance.position - view.origin(), radius};
      const uint32_t level = SphereLevel(radius * view.PixelsPerMetre(ball));
      if (spheres[level] == nullptr) spheres[level] = &list[key(level)];
      spheres[level]->push_back(record);
    }
  }
  if (!scene.triangles.empty()) {
    InstanceRecord record{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, {1, 1, 1}, 0, 0};
    list[{{Shape::kMesh, kLooseTriangles}, 0, 0, 0}].push_back(record);
  }
  std::erase_if(list, [](const auto& entry) { return entry.second.empty(); });
}

}  // namespace vesper::render
