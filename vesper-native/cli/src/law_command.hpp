// SPDX-License-Identifier: Apache-2.0
// vesper law: checks laws as text, and writes them as C++.
#pragma once

#include <string>

namespace vesper::cli {

struct LawOptions {
  std::string file;
  std::string prototype = "si-f64";
  bool json = false;
  std::string output;  // file for the C++ source; empty: standard output
};

/// Checks a law as text against a standard prototype, prints what it declares or all its problems,
/// and returns the exit code.
int CheckLaw(const LawOptions& options);

/// Translates a law as text to the C++ source of a law library, and returns the exit code.
int LawToCpp(const LawOptions& options);

}  // namespace vesper::cli
