// SPDX-License-Identifier: Apache-2.0
// A scene: the properties and laws of one run, read from a text file.
// docs/vesper-command.md describes the format.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drawing.hpp"
#include "token.hpp"
#include "vesper/kit/column.hpp"

namespace vesper::cli {

struct SceneLaw {
  std::string library;  // a bare name; or a path, only in a trusted scene
  std::vector<ParameterValue> parameters;
  Place place;
};

struct Scene {
  std::string file;
  const vesper_prototype* prototype = nullptr;
  std::optional<LoadedPrototype> own_prototype;  // if the prototype comes from a file
  double dt = 0;                                 // [the prototype's unit of time]
  uint32_t steps = 1;                            // steps per frame
  std::vector<SceneLaw> laws;
  std::map<std::string, uint64_t> rows;      // number of rows of each kind
  std::map<std::string, AnyColumn> columns;  // columns by property
  std::map<std::string, Place> places;       // the place where each property was set
  std::vector<std::string> csv;              // properties, all of one kind
  Drawing drawing;

  const AnyColumn* Find(const std::string& property) const;
};

/// Reads a scene. Throws SceneError for an error in the text, std::runtime_error if the file cannot
/// be read. Unless the scene is trusted, refuses paths of laws, and files outside the scene's
/// folder (see SceneFiles).
Scene ReadScene(const std::string& file, bool trusted);
Scene ParseScene(std::string text, const std::string& file, bool trusted = false);

}  // namespace vesper::cli
