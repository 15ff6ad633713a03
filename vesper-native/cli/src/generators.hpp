// SPDX-License-Identifier: Apache-2.0
// Readers of the values of a property, which a scene lists or generates.
#pragma once

#include <string>

#include "scene.hpp"
#include "scene_reader.hpp"

namespace vesper::cli {

/// Reads the rest of a line into all rows of a column: a value for each row, or a generator such as
/// `grid`.
void ReadColumn(SceneReader& reader, const Scene& scene, AnyColumn& column);
/// Reads one value that has the column's components.
Value ReadRow(SceneReader& reader, const AnyColumn& column);
/// Returns true if a property of that type can represent the number.
bool CanHold(const vesper_property_descriptor& property, double number);
/// Sets a row; throws SceneError, with the position of `reader`, if the column's type cannot
/// represent the value.
void SetRow(SceneReader& reader, AnyColumn& column, uint64_t row, const Value& value);

}  // namespace vesper::cli
