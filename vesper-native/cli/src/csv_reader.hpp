// SPDX-License-Identifier: Apache-2.0
// Reader of the rows of a kind from a CSV file, for example a file written with --csv.
#pragma once

#include <string>

#include "scene.hpp"

namespace vesper::cli {

/// Adds the rows of a kind to the scene. `text` is the content of `file`. Its first line contains
/// the names of the columns, such as `mass` and `position.x`, with all components of a property.
/// Skips the columns frame, time and row. If the file contains several frames, reads the last
/// frame. Throws SceneError with the place in the file.
void ReadCsvRows(std::string text, const std::string& file, const std::string& kind, Scene& scene);

}  // namespace vesper::cli
