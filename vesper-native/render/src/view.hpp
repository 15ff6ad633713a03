// SPDX-License-Identifier: Apache-2.0
// Where things of the world land in the picture. All positions here are relative to the camera's
// target: f32 is then finest where one looks, however far from the world's origin that is.
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

/// What bounds the picture's depth and shadows.
struct Extent {
  std::vector<Ball> items;    ///< all that has a definite size but planes
  std::vector<Ball> casters;  ///< those of them that cast shadows
  std::vector<Ball> planes;   ///< planes that do not fade
  bool fades = false;         ///< there are planes that do
  /// Distance [m] from the target to the far side of the farthest item, 0 without items.
  float Radius() const;
};

class View {
 public:
  View(const Camera& camera, const Image& image, const Extent& extent);

  const Vector3f& origin() const { return origin_; }      ///< the target, in the world
  const Vector3f& forward() const { return forward_; }    ///< unit vector
  const Matrix4f& clip() const { return clip_; }          ///< clip coordinates of a position
  float near() const { return near_; }                    ///< depth of the near plane [m]
  float target_height() const { return target_height_; }  ///< of the view at the target [m]
  /// Distance [m] from the target at which fading begins; it is over at kFadeEnd times that.
  float fade_radius() const { return fade_radius_; }

  /// xyz: the eye with w = 1, or the direction to it with w = 0 where the view is orthographic.
  Vector4f Eye() const;
  /// Depth [m] in front of the eye.
  float Depth(const Vector3f& position) const { return forward_.dot(position - eye_); }
  /// Size [px] of 1 m at that depth, not nearer than the near plane.
  float PixelsPerMetre(float depth) const;

 private:
  void FitDepth(const Extent& extent);
  static constexpr float kFadeEnd = 4;

  Vector3f origin_, eye_, forward_;
  bool orthographic_;
  float half_height_;  ///< of the view: [m], or [m] per [m] of depth
  float image_height_, target_height_, fade_radius_, near_ = 0, far_ = 1;
  Matrix4f clip_;
};

/// From a position to texture coordinates (0 to 1) and depth (0 to 1) seen from the light, with all
/// casters inside. `to_light` has any length but 0.
Matrix4f ShadowMatrix(const Vector3f& to_light, std::span<const Ball> casters);

/// Vertex of a line's rectangle: clip coordinates and sRGB colour.
struct LineVertex {
  std::array<float, 4> clip;
  Colour colour;
  uint32_t item;
};

/// Turns segments into rectangles of four vertices (corner order 0-1-2, 2-1-3) of their width in
/// pixels. Parts nearer than the near plane are cut off. Replaces the content of `out`.
void ExpandSegments(std::span<const Segment> segments, const View& view, const Image& image,
                    std::vector<LineVertex>& out);

}  // namespace vesper::render
