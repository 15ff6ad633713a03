// SPDX-License-Identifier: Apache-2.0
// The lines of a scene that say what its pictures show.
#pragma once

#include "scene.hpp"
#include "scene_reader.hpp"

namespace vesper::cli {

/// Each reads the words behind its own into the scene's drawing; throws SceneError.
void ReadImage(SceneReader& reader, Scene& scene);
void ReadCamera(SceneReader& reader, Scene& scene);
void ReadBackground(SceneReader& reader, Scene& scene);
void ReadGround(SceneReader& reader, Scene& scene);
void ReadDraw(SceneReader& reader, Scene& scene);

}  // namespace vesper::cli
