// SPDX-License-Identifier: Apache-2.0
// Model galaxies as rows of bodies.
#pragma once

#include "scene.hpp"
#include "scene_reader.hpp"

namespace vesper::cli {

/// galaxy ROWS…: mass M radius R at P moving V axis N seed S. Gives these bodies mass, position and
/// velocity; all bodies must have some already, and the world its gravitational constant.
void ReadGalaxy(SceneReader& reader, Scene& scene);

}  // namespace vesper::cli
