// SPDX-License-Identifier: Apache-2.0
// Contents and camera of the pictures of a scene.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "token.hpp"
#include "vesper/law.hpp"

namespace vesper::cli {

/// sRGB bytes r, g, b and 255.
using Colour = std::array<uint8_t, 4>;

/// One colour, or a gradient of evenly spaced colours; a property of the row selects the colour.
struct Paint {
  std::vector<Colour> colours;
  std::string property;  // empty: one colour
  /// Values of the property (for a vector, its length) at the first and the last colour.
  double low = 0, high = 1;
};

/// A line `draw` of a scene, which sets how rows of a kind are drawn. If several lines name a row,
/// the last of them applies.
struct DrawLine {
  std::string kind;
  std::vector<uint64_t> rows;  // empty: all rows of the kind
  Paint paint;
  std::optional<double> radius;  // radius of rows drawn as balls [m]
  std::optional<double> width;   // width of rows drawn as lines [px]
  bool unlit = false;            // no lighting, no shadow
  Place place;
};

struct Camera {
  Vec3<double> eye, target;  // [m]
  double fov = 45;           // vertical field of view [degrees]
};

struct Ground {
  double height = 0;  // height of the ground [m]
  Colour colour;
};

struct Drawing {
  uint32_t width = 960, height = 540;  // [px]
  std::optional<Camera> camera;        // none: shows all rows at their places at the start
  Colour top{255, 255, 255, 255}, bottom{226, 230, 235, 255};  // background colours
  std::optional<Ground> ground;
  std::vector<DrawLine> lines;  // none: every kind that can be drawn
};

}  // namespace vesper::cli
