// A scene: the properties, laws and pictures of one run, read from a text file.
// docs/vesper-command.md describes the format.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "token.hpp"
#include "vesper/kit/column.hpp"

namespace vesper::cli {

using Rgb = std::array<uint8_t, 3>;
using Point = std::array<double, 3>;

struct SceneLaw {
  std::string library;  // a bare name, or a path
  std::vector<ParameterValue> parameters;
  Place place;
};

/// How rows of a kind look; later entries win.
struct Look {
  std::string kind;
  std::vector<uint64_t> rows;  // empty: all
  Rgb colour{200, 200, 200};
  double radius = 0;  // [m] of balls; 0: the property `radius`
  double width = 2;   // [px] of lines
};

struct Camera {
  Point eye{0, 0, 10};         // [m]
  Point target{0, 0, 0};       // [m]
  Point up{0, 1, 0};
  double field_of_view = 45;   // vertical [deg]
};

struct Scene {
  std::string file;
  const vesper_prototype* prototype = nullptr;
  double dt = 0;            // [s]
  uint32_t steps = 1;       // per frame
  std::vector<SceneLaw> laws;
  std::map<std::string, uint64_t> rows;      // of each kind
  std::map<std::string, AnyColumn> columns;  // by property
  std::map<std::string, Place> places;       // where a property was given
  std::vector<std::string> csv;              // properties, all of one kind

  uint32_t width = 960, height = 640;  // of pictures [px]
  Camera camera;
  bool has_camera = false;
  std::vector<Look> looks;

  const AnyColumn* Find(const std::string& property) const;
};

/// Throws SceneError for what is wrong in the text, std::runtime_error if it cannot be read.
Scene ReadScene(const std::string& file);
Scene ParseScene(std::string text, const std::string& file);

}  // namespace vesper::cli
