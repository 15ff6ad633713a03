// SPDX-License-Identifier: Apache-2.0
// Projection of the world to the picture. All positions in this file are relative to the camera's
// target. Therefore f32 numbers are precise near the target, even if it is far from the world's
// origin.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene.hpp"

namespace vesper::render {

using Eigen::Matrix4f;
using Eigen::Vector4f;

/// A ball around an item, relative to the camera's target.
struct Ball {
  Vector3f centre;
  float radius;
};

/// Balls around the items of a picture, which limit its depth range and its shadow map.
struct Extent {
  std::vector<Ball> items;    ///< items of finite size, except planes
  std::vector<Ball> casters;  ///< the balls of `items` that cast shadows
  std::vector<Ball> planes;   ///< planes that do not fade
  bool fades = false;         ///< true if there are planes that fade
  /// Returns the distance [m] from the target to the far side of the farthest item; 0 without
  /// items.
  float Radius() const;
};

class View {
 public:
  View(const Camera& camera, const Image& image, const Extent& extent);

  const Vector3f& origin() const { return origin_; }    ///< the target, in world coordinates
  const Vector3f& forward() const { return forward_; }  ///< unit vector to the target
  const Matrix4f& clip() const {
    return clip_;
  }  ///< transforms a position to clip
     ///< coordinates
  float near() const { return near_; }                    ///< depth of the near plane [m]
  float target_height() const { return target_height_; }  ///< height of the view at the target [m]
  /// Returns the distance [m] from the target at which fading begins. Fading ends at kFadeEnd times
  /// this distance.
  float fade_radius() const { return fade_radius_; }

  /// Returns the position of the eye with w = 1. For an orthographic view, returns the direction to
  /// the eye with w = 0.
  Vector4f Eye() const;
  /// Returns the depth of a position: its distance [m] in front of the eye, along the view
  /// direction.
  float Depth(const Vector3f& position) const { return forward_.dot(position - eye_); }
  /// Returns the size [px] of 1 m at a depth; depths before the near plane count as the near plane.
  float PixelsPerMetre(float depth) const;
  /// Returns a size [px] of 1 m that no visible point of a ball exceeds.
  float PixelsPerMetre(const Ball& ball) const;

 private:
  void FitDepth(const Extent& extent);
  static constexpr float kFadeEnd = 4;

  Vector3f origin_, eye_, forward_;
  bool orthographic_;
  float half_height_;  ///< half height of the view: [m] if orthographic, else [m] per [m] of depth
  float corner_;       ///< cosine of the angle between the view direction and a corner of the view
  float image_height_, target_height_, fade_radius_, near_ = 0, far_ = 1;
  Matrix4f clip_;
};

/// Returns the transformation from a position to texture coordinates (0 to 1) and depth (0 to 1) as
/// seen from the light, with all casters inside. `to_light` has any length but 0.
Matrix4f ShadowMatrix(const Vector3f& to_light, std::span<const Ball> casters);

/// Vertex of a line's rectangle: clip coordinates and sRGB colour.
struct LineVertex {
  std::array<float, 4> clip;
  Colour colour;
  uint32_t item;
};

/// Converts segments to rectangles of four vertices (triangles 0-1-2, 2-1-3) that have the
/// segments' widths in pixels. Parts before the near plane are cut off. Replaces the content of
/// `out`.
void ExpandSegments(std::span<const Segment> segments, const View& view, const Image& image,
                    std::vector<LineVertex>& out);

}  // namespace vesper::render
