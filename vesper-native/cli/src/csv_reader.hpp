// SPDX-License-Identifier: Apache-2.0
// Reader of the rows of a kind from a CSV file, for example a file written with --csv.
#pragma once

#include <string>

#include "scene.hpp"

namespace vesper::cli {

/// Adds the rows of the kind and the columns named in the first line of `text`, the content of
/// `file`: `mass`, `position.x`, …, with all components of a property. Skips the columns frame,
/// time and row. If the file contains several frames, reads the last one. Throws SceneError with
/// the place in the file.
void ReadCsvRows(std::string text, const std::string& file, const std::string& kind, Scene& scene);

}  // namespace vesper::cli
