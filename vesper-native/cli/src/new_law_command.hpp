// SPDX-License-Identifier: Apache-2.0
// vesper new-law: writes a folder with a new law, complete with build file and test.
#pragma once

#include <string>

namespace vesper::cli {

struct NewLawOptions {
  std::string name;          // snake_case
  std::string folder = ".";  // parent of the new law's folder
};

/// Returns the exit code. Writes nothing if the law's folder already exists.
int WriteNewLaw(const NewLawOptions& options);

}  // namespace vesper::cli
