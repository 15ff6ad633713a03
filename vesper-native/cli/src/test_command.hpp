// SPDX-License-Identifier: Apache-2.0
// vesper test: checks law libraries against the rules for all laws, and against their claims.
#pragma once

#include <string>
#include <vector>

namespace vesper::cli {

struct TestOptions {
  std::vector<std::string> libraries;  // files
  std::vector<std::string> only;       // names of checks; empty: all checks
  std::string python;                  // virtual environment of laws in Python; empty: the system's
  std::string prototype;               // prototype file of the worlds; empty: a standard one
  bool json = false;
};

/// Returns the names of all checks in execution order.
std::vector<std::string> CheckNames();

/// Returns the exit code: 1 if a check failed.
int TestLaws(const TestOptions& options);

}  // namespace vesper::cli
