// SPDX-License-Identifier: Apache-2.0
// vesper law: checks laws as text.
#pragma once

#include <string>

namespace vesper::cli {

struct LawOptions {
  std::string file;
  std::string prototype = "si-f64";
  bool json = false;
};

/// Checks a law as text against a standard prototype, prints what it declares or all its problems,
/// and returns the exit code.
int CheckLaw(const LawOptions& options);

}  // namespace vesper::cli
