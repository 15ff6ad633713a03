// SPDX-License-Identifier: Apache-2.0
// Model galaxies as rows of bodies.
#pragma once

#include "scene.hpp"
#include "scene_reader.hpp"

namespace vesper::cli {

/// Reads `galaxy ROWS…: mass M radius R at P moving V axis N seed S` and gives these bodies mass,
/// position and velocity. All bodies must already have these properties, and the world a
/// gravitational constant.
void ReadGalaxy(SceneReader& reader, Scene& scene);

}  // namespace vesper::cli
