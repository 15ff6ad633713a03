// SPDX-License-Identifier: Apache-2.0
// Draws a scene as it stands: rows with a position as balls, rows that refer to two of those as
// lines, to three as triangles.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer_process.hpp"
#include "scene.hpp"

namespace vesper::cli {

enum class Form { kNone, kBalls, kLines, kTriangles };

/// How rows of a kind can be drawn.
Form FormOf(const Scene& scene, const std::string& kind);

/// Where pictures go: a path with the frame's number in it.
class PicturePattern {
 public:
  /// "frame-%04d.png": one %d or %0Nd, and %% for a percent sign. Throws std::invalid_argument.
  explicit PicturePattern(const std::string& text);
  std::string For(uint64_t frame) const;

 private:
  std::string before_, after_;
  size_t digits_ = 0;  // at least
};

class PictureWriter {
 public:
  /// `scene`: borrowed; its columns may change between pictures, their sizes may not. `program`:
  /// the renderer. Throws SceneError where a kind cannot be drawn, RendererError.
  PictureWriter(const Scene& scene, PicturePattern pattern, const std::string& program);

  /// Throws FileError if the picture cannot be written, RendererError if it cannot be drawn.
  void WriteFrame(uint64_t frame);

 private:
  /// The rows of a kind that one line of the scene draws.
  struct Layer {
    DrawLine line;
    Form form;
    std::vector<uint64_t> rows;
  };

  struct Box {
    Vec3<double> low, high;
    double Side() const;  // the longest one
  };

  std::vector<Layer> MakeLayers() const;
  void SetUp();
  Box BoundsOf() const;
  Camera Fit(const Box& box) const;
  void SendGround(const Ground& ground, const Box& box);
  void SendBalls(const Layer& layer);
  void SendLines(const Layer& layer);
  void SendTriangles(const Layer& layer);
  std::vector<Colour> ColoursOf(const Layer& layer) const;
  std::array<float, 3> PositionOf(const AnyColumn& references, uint64_t row, uint32_t which) const;

  const Scene& scene_;
  PicturePattern pattern_;
  std::vector<Layer> layers_;
  double radius_ = 0;  // of balls whose radius nobody gives [m]
  uint32_t mesh_ = 0;  // the last one of this picture
  RendererProcess renderer_;
};

}  // namespace vesper::cli
