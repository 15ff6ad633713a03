// SPDX-License-Identifier: Apache-2.0
// Model galaxies as rows of bodies.
#pragma once

#include "scene.hpp"
#include "scene_reader.hpp"

namespace vesper::cli {

/// Reads `galaxy ROWS…: mass M radius R at P moving V axis N seed S` and sets mass, position and
/// velocity of these bodies. The scene must already contain these properties for all bodies, and a
/// gravitational constant.
void ReadGalaxy(SceneReader& reader, Scene& scene);

}  // namespace vesper::cli
