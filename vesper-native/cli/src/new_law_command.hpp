// SPDX-License-Identifier: Apache-2.0
// vesper new-law: writes a folder with a law that builds, is tested and acts.
#pragma once

#include <string>

namespace vesper::cli {

struct NewLawOptions {
  std::string name;          // snake_case
  std::string folder = ".";  // where the folder of the law is made
};

/// The exit code. Writes nothing if the law's folder is there already.
int WriteNewLaw(const NewLawOptions& options);

}  // namespace vesper::cli
