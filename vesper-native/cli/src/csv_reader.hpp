// SPDX-License-Identifier: Apache-2.0
// Rows of a kind from a CSV file, such as the one that --csv writes.
#pragma once

#include <string>

#include "scene.hpp"

namespace vesper::cli {

/// Adds the kind's rows and the columns that the file's first line names: `mass`, `position.x`, …,
/// all components of a property. The columns frame, time and row are passed over; of several frames
/// the last one is read. Throws SceneError with the place in the file.
void ReadCsvRows(const std::string& file, const std::string& kind, Scene& scene);

}  // namespace vesper::cli
