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

/// One colour, or a gradient of evenly spaced colours, indexed by a property of the row.
struct Paint {
  std::vector<Colour> colours;
  std::string property;  // empty: one colour
  /// Values of the property (the length of a vector) at the first and the last colour.
  double low = 0, high = 1;
};

/// Style of rows of a kind. For each row the last line that names it applies.
struct DrawLine {
  std::string kind;
  std::vector<uint64_t> rows;  // empty: all
  Paint paint;
  std::optional<double> radius;  // for balls [m]
  std::optional<double> width;   // for lines [px]
  bool unlit = false;            // no lighting, no shadow
  Place place;
};

struct Camera {
  Vec3<double> eye, target;  // [m]
  double fov = 45;           // vertical field of view [degrees]
};

struct Ground {
  double height = 0;  // [m]
  Colour colour;
};

struct Drawing {
  uint32_t width = 960, height = 540;  // [px]
  std::optional<Camera> camera;        // none: a view of everything that exists at the start
  Colour top{255, 255, 255, 255}, bottom{226, 230, 235, 255};  // background colours
  std::optional<Ground> ground;
  std::vector<DrawLine> lines;  // none: every kind that can be drawn
};

}  // namespace vesper::cli
