// SPDX-License-Identifier: Apache-2.0
// Readers of those lines of a scene file that describe its pictures.
#pragma once

#include "scene.hpp"
#include "scene_reader.hpp"

namespace vesper::cli {

/// Each function reads the words after its keyword into the scene's drawing; throws SceneError.
void ReadImage(SceneReader& reader, Scene& scene);
void ReadCamera(SceneReader& reader, Scene& scene);
void ReadBackground(SceneReader& reader, Scene& scene);
void ReadGround(SceneReader& reader, Scene& scene);
void ReadDraw(SceneReader& reader, Scene& scene);

}  // namespace vesper::cli
