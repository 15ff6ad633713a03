// SPDX-License-Identifier: Apache-2.0
// What the pictures of a scene show, and from where.
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

/// One colour, or several at even distances, chosen by a property of the row.
struct Paint {
  std::vector<Colour> colours;
  std::string property;  // empty: one colour
  /// Of the property (the length of a vector), at the first and the last colour.
  double low = 0, high = 1;
};

/// How rows of a kind are drawn. The last line that names a row decides.
struct DrawLine {
  std::string kind;
  std::vector<uint64_t> rows;  // empty: all
  Paint paint;
  std::optional<double> radius;  // of balls [m]
  std::optional<double> width;   // of lines [px]
  bool unlit = false;            // no light, no shadow
  Place place;
};

struct Camera {
  Vec3<double> eye, target;  // [m]
  double fov = 45;           // from bottom to top [degrees]
};

struct Ground {
  double height = 0;  // [m]
  Colour colour;
};

struct Drawing {
  uint32_t width = 960, height = 540;  // [px]
  std::optional<Camera> camera;        // none: all that is there at the start
  Colour top{255, 255, 255, 255}, bottom{226, 230, 235, 255};  // background
  std::optional<Ground> ground;
  std::vector<DrawLine> lines;  // none: every kind that can be drawn
};

}  // namespace vesper::cli
