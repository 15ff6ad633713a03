// SPDX-License-Identifier: Apache-2.0
// Prototypes as data files, so that properties can be added without code.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "vesper/types.h"

namespace vesper {

/// A prototype that owns all data to which it points.
struct OwnedPrototype : vesper_prototype {
  std::vector<vesper_property_descriptor> descriptors;
  std::vector<std::unique_ptr<std::string>> strings;
};

/// Reads the format that docs/properties-and-units.md describes. Throws a Failure whose message
/// begins with `source`:line:column. The result is a valid prototype.
std::unique_ptr<OwnedPrototype> ParsePrototype(std::string_view text, const std::string& source);

/// Reads a prototype from a file. Throws NOT_FOUND if the file cannot be read, INVALID_ARGUMENT if
/// it is too large.
std::unique_ptr<OwnedPrototype> LoadPrototype(const std::string& path);

}  // namespace vesper
