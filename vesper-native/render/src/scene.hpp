// SPDX-License-Identifier: Apache-2.0
// The content of one picture, decoded from the scene stream (SCENE.md). The decoder has checked
// every rule of SCENE.md, so a renderer may rely on them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

namespace vesper::render {

using Eigen::Vector3f;

/// sRGB bytes r, g, b, and an unused fourth byte.
using Colour = std::array<uint8_t, 4>;

enum class Shape : uint32_t { kSphere = 1, kBox = 2, kPlane = 3, kMesh = 4 };

enum ItemFlags : uint32_t { kUnlit = 1, kGrid = 2, kFade = 4 };

struct Image {
  uint32_t width = 640, height = 480;  ///< [px]
  uint32_t samples = 4;                ///< requested samples per pixel
  bool shadows = true;
};

struct Camera {
  bool orthographic = false;
  Vector3f eye, target, up;  ///< [m]; `up` has any length
  float extent = 0;          ///< perspective: vertical field of view [rad]; orthographic: height of
                             ///< the view [m]
};

struct Environment {
  Colour top{255, 255, 255, 255}, bottom{226, 230, 235, 255};
  Vector3f to_light{-0.5F, 1, 0.4F};  ///< any length except 0
  float light = 0.65F, ambient = 0.48F;
};

struct Mesh {
  std::vector<Vector3f> positions;
  std::vector<Vector3f> normals;                  ///< one per position, or none; the normal 0 makes
                                                  ///< its triangles flat
  std::vector<std::array<float, 2>> coordinates;  ///< one per position, or none
  std::vector<Colour> colours;                    ///< one per position, or none: white
  std::vector<uint32_t> indices;                  ///< three per triangle
  uint64_t revision = 0;                          ///< unique among all meshes, also deleted ones
};

struct Texture {
  uint32_t width, height;       ///< [px]
  std::vector<uint8_t> pixels;  ///< (height x width x 4) sRGB bytes r g b a, from the upper left
  uint64_t revision = 0;        ///< unique among all textures, also deleted ones
};

struct Material {
  Colour colour{255, 255, 255, 255};
  float roughness = 0.45F, metallic = 0;  ///< 0 to 1
  uint32_t texture = 0;                   ///< id, or 0 for none
};

struct Instance {
  Vector3f position;               ///< [m]
  Eigen::Quaternionf orientation;  ///< unit length within one percent
  Vector3f size;                   ///< not negative
  Colour colour;
  uint32_t flags;  ///< ItemFlags
  uint32_t item;   ///< the sender's number of the item; 0 for none
};

struct InstanceBatch {
  Shape shape;
  uint32_t mesh;                            ///< id, for Shape::kMesh
  uint32_t material;                        ///< id, or 0 for the default
  uint32_t first_triangle, triangle_count;  ///< the part of a mesh that is drawn; count 0: all
  std::vector<Instance> instances;
};

struct Triangle {
  std::array<Vector3f, 3> corners;  ///< [m]
  std::array<Colour, 3> colours;    ///< one per corner
  uint32_t item;                    ///< as in Instance
};

struct Segment {
  Vector3f from, to;  ///< [m]
  Colour colour;
  float width;    ///< [px]
  uint32_t item;  ///< as in Instance
};

struct Scene {
  Image image;
  Camera camera;
  Environment environment;
  std::map<uint32_t, Mesh> meshes;
  std::map<uint32_t, Texture> textures;
  std::map<uint32_t, Material> materials;
  std::vector<InstanceBatch> batches;
  std::vector<Segment> segments;
  std::vector<Triangle> triangles;
};

}  // namespace vesper::render
