// SPDX-License-Identifier: Apache-2.0
// Draws the current state of a scene: rows with a position as balls, rows that refer to two such
// rows as lines, and rows that refer to three as triangles.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer_process.hpp"
#include "scene.hpp"

namespace vesper::cli {

enum class Form { kNone, kBalls, kLines, kTriangles };

/// Returns whether rows of a kind are drawn as balls, lines or triangles.
Form FormOf(const Scene& scene, const std::string& kind);

/// Path pattern of pictures, with a placeholder for the frame number.
class PicturePattern {
 public:
  /// Parses a pattern such as "frame-%04d.png": one %d or %0Nd, and %% for a percent sign. Throws
  /// std::invalid_argument.
  explicit PicturePattern(const std::string& text);
  std::string For(uint64_t frame) const;

 private:
  std::string before_, after_;
  size_t digits_ = 0;  // minimum width, padded with zeros
};

class PictureWriter {
 public:
  /// Starts the renderer `program`. `scene` must outlive the writer; its values may change between
  /// pictures, but not its numbers of rows. Throws SceneError if a kind cannot be drawn, and
  /// RendererError.
  PictureWriter(const Scene& scene, PicturePattern pattern, const std::string& program);

  /// Draws and writes a picture. Throws FileError if it cannot be written, RendererError if it
  /// cannot be drawn.
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
    double Side() const;  // length of the longest side
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
  double radius_ = 0;  // default radius of balls [m]
  uint32_t mesh_ = 0;  // the last mesh id used for this picture
  RendererProcess renderer_;
};

}  // namespace vesper::cli
