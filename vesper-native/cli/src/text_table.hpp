// SPDX-License-Identifier: Apache-2.0
// A table of text with columns as wide as their widest entry.
#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace vesper::cli {

using TextTable = std::vector<std::vector<std::string>>;  // rows of cells

/// Prints each row on one line after `indent`, with two blanks between columns.
void Print(std::ostream& out, const TextTable& table, const std::string& indent = "");

}  // namespace vesper::cli
